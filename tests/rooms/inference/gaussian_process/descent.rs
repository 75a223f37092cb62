//! Tests of `core/src/inference/gaussian_process/descent.rs`.

use bmv::inference::gaussian_process::descent::*;

/// Rosenbrock's valley (1960): minimum 0 at (1, 1).
fn valley(x: &[f64], gradient: &mut [f64]) -> Option<f64> {
    let bend = x[1] - x[0] * x[0];
    gradient[0] = -400.0 * x[0] * bend - 2.0 * (1.0 - x[0]);
    gradient[1] = 200.0 * bend;
    Some(100.0 * bend * bend + (1.0 - x[0]) * (1.0 - x[0]))
}

#[test]
fn a_curved_valley_is_followed_to_its_end_and_to_a_bound() {
    let free = descend(valley, &[-1.2, 1.0], &[[-5.0, 5.0]; 2], None, 1e-14, 500).expect("a value");
    assert!((free.x[0] - 1.0).abs() < 1e-5 && (free.x[1] - 1.0).abs() < 1e-5, "{free:?}");
    // With x below 0.5 the best is y = x^2 there.
    let bounded = descend(valley, &[-1.2, 1.0], &[[-5.0, 0.5], [-5.0, 5.0]], None, 1e-14, 500).expect("a value");
    assert!((bounded.x[0] - 0.5).abs() < 1e-12 && (bounded.x[1] - 0.25).abs() < 1e-6, "{bounded:?}");
    assert!(descend(|_, _| None, &[0.0], &[[-1.0, 1.0]], None, 1e-9, 10).is_none());
}
