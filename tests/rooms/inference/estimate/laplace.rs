//! Tests of `core/src/inference/estimate/laplace.rs`.

use bmv::inference::estimate::laplace::*;

#[test]
fn the_integral_from_a_bound_has_its_limits() {
    // Steep: 1/g. Flat: the width. Curved: half a normal integral.
    assert!((pinned_integral(50.0, 0.0, f64::INFINITY) - 0.02).abs() < 1e-12);
    assert!((pinned_integral(2.0, 0.0, 1.0) - 0.5 * (1.0 - libm::exp(-2.0))).abs() < 1e-12);
    assert!((pinned_integral(0.0, 0.0, 3.0) - 3.0).abs() < 1e-12);
    let half = 0.5 * core::f64::consts::TAU.sqrt() / 2.0;
    assert!((pinned_integral(0.0, 4.0, f64::INFINITY) - half).abs() < 1e-12);
}
