//! Tests of `core/src/inference/information/mixture.rs`.

use bmv::inference::information::mixture::*;
use bmv::math::functions::{exp, ln};
use bmv::random::StreamKey;

#[test]
fn a_linear_model_has_its_evidence() {
    // z = J u + e, two readings, three unknowns: z ~ N(0, I + J J').
    let j = [2.0, -1.0, 0.5, 0.3, 4.0, 1.0];
    let z = [1.7, -3.1];
    let mixture = Mixture::linearised(&j, &z, &[0.0; 3]).expect("regular");
    let (a, b, c) = (1.0 + 4.0 + 1.0 + 0.25, 0.6 - 4.0 + 0.5, 1.0 + 0.09 + 16.0 + 1.0);
    let determinant: f64 = a * c - b * b;
    let square = (c * z[0] * z[0] - 2.0 * b * z[0] * z[1] + a * z[1] * z[1]) / determinant;
    let exact = -0.5 * (square + ln(determinant));
    let mut stream = StreamKey::new(1, "mixture", "test").stream(0);
    let draws = 4096;
    let (mut sum, mut squares) = (0.0, 0.0);
    for index in 0..draws {
        let mut draw = [stream.normal(), stream.normal(), stream.normal()];
        mixture.place(index, &mut draw);
        let apart = |reading: usize| z[reading] - (0..3).map(|k| j[reading * 3 + k] * draw[k]).sum::<f64>();
        let log = -0.5 * (apart(0) * apart(0) + apart(1) * apart(1));
        let term = exp(log + mixture.log_weight(&draw, draws) - exact);
        sum += term;
        squares += term * term;
    }
    // The terms are 0 for nearly all draws from the prior and 8 / 7 for the others; four standard errors.
    let mean = sum / draws as f64;
    let error = ((squares / draws as f64 - mean * mean) / draws as f64).sqrt();
    assert!((mean - 1.0).abs() < 4.0 * error && error < 0.01, "{mean} {error}");
}

#[test]
fn the_mean_solves_the_normal_equations() {
    let mixture = Mixture::linearised(&[3.0], &[0.5], &[1.0]).expect("regular");
    // u = J (r + J at) / (1 + J^2) = 3 * 3.5 / 10.
    assert!((mixture.mean()[0] - 1.05).abs() < 1e-15);
    assert!(Mixture::linearised(&[f64::NAN], &[0.0], &[0.0]).is_err());
}
