//! Tests of `src/job/propagate/reached.rs`.

use bmv::job::propagate::reached::*;
use bmv::math::special::normal_cdf;

#[test]
fn a_normal_curve_is_crossed_exactly() {
    // P(x) = Phi((x - 0.3) / 0.01) is straight on the probit scale.
    let points: Vec<(f64, f64)> =
        (0..12).map(|i| 0.28 + 0.005 * f64::from(i)).map(|x| (x, normal_cdf((x - 0.3) / 0.01))).collect();
    let x = crossing(&points, 0.99, 1_000_000).expect("crossed");
    assert!((x - (0.3 + 0.01 * 2.326_347_874_040_841)).abs() < 1e-9, "{x}");
}

#[test]
fn a_curve_that_stays_below_is_not_crossed_and_one_above_starts_at_once() {
    assert_eq!(crossing(&[(1.0, 0.2), (2.0, 0.5)], 0.9, 100), None);
    assert_eq!(crossing(&[(1.0, 0.95), (2.0, 0.99)], 0.9, 100), Some(1.0));
}

#[test]
fn a_falling_sweep_finds_the_largest_value() {
    // P(x) = Phi((x0 - x) / s): the mirror of the rising curve.
    let points: Vec<(f64, f64)> =
        (0..16).map(|i| 50.0 - 2.0 * f64::from(i)).map(|x| (x, normal_cdf((36.0 - x) / 2.5))).collect();
    let x = crossing(&points, 0.99, 1_000_000).expect("crossed");
    assert!((x - (36.0 - 2.5 * 2.326_347_874_040_841)).abs() < 1e-9, "{x}");
}

#[test]
fn a_dip_counts() {
    let x = crossing(&[(1.0, 0.95), (2.0, 0.5), (3.0, 0.95)], 0.9, 100).expect("crossed");
    assert!(x > 2.0 && x < 3.0);
}
