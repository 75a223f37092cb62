//! Tests of `core/src/inference/sampler/student.rs`.

use bmv::inference::sampler::student::*;
use bmv::math::functions::ln;
use bmv::random::StreamKey;

/// In one dimension with one degree of freedom Cauchy's density `1 / (pi s (1 + (x / s)^2))`; a draw has the density that is
/// given with it.
#[test]
fn densities_are_those_of_the_draws() {
    let mut cauchy = StudentProposal::new(vec![1.0], vec![2.0], 1);
    let expected = -ln(core::f64::consts::PI * 2.0 * (1.0 + 2.25));
    assert!((cauchy.log_density(&[4.0]) - expected).abs() < 1e-13);
    let mut stream = StreamKey::new(1, "student", "test").stream(0);
    let mut point = [0.0];
    let given = cauchy.draw(&mut stream, &mut point);
    assert!((cauchy.log_density(&point) - given).abs() < 1e-12);
}
