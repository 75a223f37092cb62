//! Tests of `src/job/calibrate/predictive.rs`.

use bmv::job::calibrate::predictive::*;
use bmv::math::special::normal_quantile;

#[test]
fn a_band_with_noise_is_that_of_the_sum() {
    // Predictions of one value with noise 2: 95 % of a normal.
    let [lower, upper] = noisy_band(&vec![(10.0, 2.0); 1000]);
    assert!((lower - (10.0 - 3.92)).abs() < 0.01 && (upper - 13.92).abs() < 0.01, "{lower} {upper}");
    // Predictions and noise together: variances add.
    let spread: Vec<(f64, f64)> =
        (0..1000).map(|i| (3.0 * normal_quantile((f64::from(i) + 0.5) / 1000.0), 4.0)).collect();
    let [lower, upper] = noisy_band(&spread);
    assert!((lower + 9.8).abs() < 0.05 && (upper - 9.8).abs() < 0.05, "{lower} {upper}");
}
