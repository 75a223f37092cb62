//! Tests of `core/src/inference/sampler/metric.rs`.

use bmv::inference::sampler::adaptation::RunningCovariance;
use bmv::inference::sampler::metric::*;
use bmv::random::StreamKey;

#[test]
fn kinetic_energy_of_momenta_is_half_the_dimension() {
    let mut metric = Metric::unit(2, true);
    let mut window = RunningCovariance::new(2);
    for i in 0..200 {
        let t = f64::from(i) / 10.0;
        window.add(&[t % 1.7, (t % 1.7) * 0.5 + (t % 0.9)]);
    }
    metric.learn(&window, None);
    let mut stream = StreamKey::new(1, "metric", "test").stream(0);
    let (mut p, mut v, mut sum) = ([0.0; 2], [0.0; 2], 0.0);
    let draws = 20_000;
    for _ in 0..draws {
        metric.draw_momentum(&mut stream, &mut p);
        metric.velocity(&p, &mut v);
        sum += 0.5 * (p[0] * v[0] + p[1] * v[1]);
    }
    // Chi-square with two degrees of freedom, halved: mean 1, standard error 1 / sqrt(20000) = 0.007.
    assert!((sum / f64::from(draws) - 1.0).abs() < 0.03);
}
