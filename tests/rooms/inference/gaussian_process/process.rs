//! Tests of `core/src/inference/gaussian_process/process.rs`.

use bmv::inference::gaussian_process::process::*;
use bmv::inference::gaussian_process::{Form, Kernel, Training, Trend};
use bmv::math::functions::ln;
use bmv::random::StreamKey;

fn training() -> Training {
    Training::new(1, vec![0.0, 1.0, 2.5, 4.0], vec![0.5, 0.8, -0.2, 0.1], vec![0.0; 4]).expect("points")
}

fn golden() -> Process {
    let form = Form { kernel: Some(Kernel::SquaredExponential), trend: Trend::None, scatter: true };
    Process::new(training(), form, &[ln(0.7), ln(1.2), ln(0.01)]).expect("a process")
}

#[test]
fn a_linear_functional_of_the_values_gives_the_mean_with_each_trend() {
    let training = training();
    for trend in [Trend::None, Trend::Constant, Trend::Linear] {
        for kernel in [None, Some(Kernel::SquaredExponential), Some(Kernel::Matern52)] {
            let form = Form { kernel, trend, scatter: true };
            let hyperparameters = if kernel.is_some() { vec![ln(0.7), ln(1.2), ln(0.01)] } else { vec![ln(0.3)] };
            let process = Process::new(training.clone(), form, &hyperparameters).expect("a process");
            for point in [[1.7], [9.0]] {
                let (expected, functional) = (process.at(&point), process.functional(&point));
                let mean: f64 = functional.weights.iter().zip(training.values()).map(|(w, r)| w * r).sum();
                assert!((mean - expected.mean).abs() < 1e-12, "{mean} {expected:?}");
                assert_eq!(functional.variance, expected.variance);
            }
        }
    }
}

#[test]
fn draws_have_the_means_and_covariances_that_are_said() {
    let process = golden();
    let points = vec![vec![1.7], vec![1.9], vec![6.0]];
    let (means, covariance) = process.together(&points);
    let key = StreamKey::new(1, "gp", "draws");
    let draws: Vec<Vec<f64>> =
        (0..20_000).map(|i| process.draw(&points, &mut key.stream(i)).expect("a draw")).collect();
    for a in 0..3 {
        for b in 0..3 {
            let product: f64 = draws.iter().map(|d| (d[a] - means[a]) * (d[b] - means[b])).sum::<f64>() / 20_000.0;
            let spread =
                (covariance[a * 3 + a] * covariance[b * 3 + b] + covariance[a * 3 + b] * covariance[a * 3 + b]).sqrt();
            // Five standard errors of a product of normals.
            assert!((product - covariance[a * 3 + b]).abs() < 5.0 * spread / 20_000f64.sqrt(), "{a} {b} {product}");
        }
    }
    assert!((process.at(&points[0]).variance - covariance[0]).abs() < 1e-14);
}
