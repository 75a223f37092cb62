//! Tests of `core/src/statistics/quantile.rs`.

use bmv::math::functions::sqrt;
use bmv::statistics::quantile::*;

#[test]
fn grouped_ranks_give_the_error_of_single_ones() {
    // 10^5 exponential values at the expected places: sd of the p quantile is sqrt(p / ((1 - p) n)) for large n.
    let n = 100_000;
    let values: Vec<f64> =
        (0..n).map(|k| -bmv::math::functions::ln(1.0 - (f64::from(k) + 0.5) / f64::from(n))).collect();
    for p in [0.01, 0.5, 0.99] {
        let error = quantile_standard_error_sorted(&values, p);
        let expected = sqrt(p / ((1.0 - p) * f64::from(n)));
        // The next term of the expansion is of the order 1 / (n p (1 - p)), 1e-3.
        assert!((error / expected - 1.0).abs() < 2e-3, "{p}: {error} {expected}");
    }
    assert_eq!(quantile_standard_error_sorted(&[3.0; 100], 0.5), 0.0);
}

#[test]
fn type_seven_quantiles_by_hand() {
    let values = sorted(&[4.0, 1.0, 3.0, 2.0]);
    assert_eq!([0.0, 0.25, 0.5, 1.0].map(|p| quantile_sorted(&values, p)), [1.0, 1.75, 2.5, 4.0]);
    assert_eq!(quantile_sorted(&[7.0], 0.3), 7.0);
    assert!(quantile_sorted(&[], 0.5).is_nan());
}
