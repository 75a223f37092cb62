//! Tests of `core/src/inference/posterior.rs`.

use bmv::inference::posterior::*;
use bmv::inference::prior::triangular_transport::NormalApproximation;
use bmv::inference::target::{Rejected, Target};
use bmv::random::Distribution;

/// A ridge between a uniform, a log-normal and a normal parameter.
struct Ridge {
    names: Vec<String>,
    priors: Vec<Distribution>,
}

impl Target for Ridge {
    type Workspace = ();

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) {}

    fn log_likelihood(&self, x: &[f64], (): &mut ()) -> Result<f64, Rejected> {
        let (along, across) = (x[0] - x[1], x[0] + x[2]);
        Ok(-50.0 * along * along - 20.0 * across * across)
    }

    fn log_likelihood_gradient(&self, x: &[f64], (): &mut (), gradient: &mut [f64]) -> Result<f64, Rejected> {
        let (a, b) = (100.0 * (x[0] - x[1]), 40.0 * (x[0] + x[2]));
        gradient.copy_from_slice(&[-a - b, a, -b]);
        self.log_likelihood(x, &mut ())
    }
}

fn ridge() -> (Ridge, NormalApproximation) {
    let priors = vec![
        Distribution::Uniform { lower: 0.0, upper: 1.0 },
        Distribution::LogNormal { median: 0.3, factor: 3.0 },
        Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: None },
    ];
    let covariance = vec![0.01, 0.009, -0.008, 0.009, 0.0125, -0.007, -0.008, -0.007, 0.012];
    let names = ["a", "b", "c"].map(str::to_owned).to_vec();
    (Ridge { names, priors }, NormalApproximation { mode: vec![0.15, 0.16, -0.15], covariance })
}

#[test]
fn gradients_over_sheared_coordinates_agree_with_central_differences() {
    let (target, normal) = ridge();
    let posterior = Posterior::along(&target, &normal).expect("maps");
    let plain = Posterior::new(&target).expect("maps");
    assert_ne!(posterior.coordinates(&[0.1, 0.2, 0.3]), plain.coordinates(&[0.1, 0.2, 0.3]), "it is sheared");
    let mut evaluator = posterior.evaluator();
    let mut gradient = [0.0; 3];
    for at in [[-2.0, 0.3, -0.4], [0.1, -0.8, 0.2], [-4.0, 0.5, 0.7]] {
        evaluator.density_gradient(&at, &mut gradient).expect("a density");
        for i in 0..3 {
            // Central differences with this step are good to 1e-8 on derivatives of order 1 to 100.
            let (mut above, mut below) = (at, at);
            above[i] += 1e-5;
            below[i] -= 1e-5;
            let mut total = |z: &[f64]| evaluator.density(z).expect("a density").total();
            let slope = (total(&above) - total(&below)) / 2e-5;
            assert!((slope - gradient[i]).abs() < 1e-6 * slope.abs().max(1.0), "{at:?} {i}: {slope} {gradient:?}");
        }
    }
}

#[test]
fn sheared_coordinates_go_there_and_back_and_keep_the_volume() {
    let (target, normal) = ridge();
    let (posterior, plain) =
        (Posterior::along(&target, &normal).expect("maps"), Posterior::new(&target).expect("maps"));
    for x in [[0.15, 0.16, -0.15], [0.01, 0.9, 0.4], [0.99, 0.05, -2.0]] {
        let w = posterior.coordinates(&x);
        let back = posterior.parameters(&w);
        assert!(x.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-9), "{x:?} {back:?}");
        // The same parameters have the same density with or without the shear.
        let (sheared, other) = (posterior.evaluator().density(&w), plain.evaluator().density(&plain.coordinates(&x)));
        let (sheared, other) = (sheared.expect("a density").total(), other.expect("a density").total());
        assert!((sheared - other).abs() < 1e-9 * sheared.abs().max(1.0), "{sheared} {other}");
    }
}
