//! Tests of `core/src/statistics/moments.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::statistics::moments::*;

#[test]
fn moments_of_a_hand_sample() {
    // 2 4 4 4 5 5 7 9: mean 5, squared deviations 32, cubes 42, fourth powers 356.
    let m = Moments::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
    assert_eq!((m.count(), m.mean()), (8, 5.0));
    assert!((m.variance() - 32.0 / 7.0).abs() < 1e-15);
    assert!((m.skewness() - 42.0 / 8.0 / 8.0).abs() < 1e-15);
    assert!((m.kurtosis() - 356.0 / 8.0 / 16.0).abs() < 1e-15);
    assert!((m.mean_standard_error() - (4.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    assert!(Moments::of(&[]).mean().is_nan() && Moments::of(&[1.0]).variance().is_nan());
}

#[test]
fn large_offsets_cost_no_digits() {
    // NIST's NumAcc4 in kind: 1e7 + 0.1, 0.2, 0.3 alternating has standard deviation 0.1.
    let values: Vec<f64> = (0..1001).map(|k| 1e7 + [0.2, 0.1, 0.3][if k == 0 { 0 } else { 1 + k % 2 }]).collect();
    assert!((Moments::of(&values).sd() - 0.1).abs() < 1e-8, "the data themselves carry 1e-9");
}

#[test]
fn merged_blocks_are_the_whole() {
    let values: Vec<f64> = (0..1000).map(|k| 50.0 + f64::from(k * k * 37 % 1009).sin().exp()).collect();
    let whole = Moments::of(&values);
    let mut merged = Moments::default();
    values.chunks(77).for_each(|block| merged.merge(&Moments::of(block)));
    for (a, b) in [
        (whole.mean(), merged.mean()),
        (whole.variance(), merged.variance()),
        (whole.kurtosis(), merged.kurtosis()),
        (1.0 + whole.skewness(), 1.0 + merged.skewness()),
    ] {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }
    assert_eq!(merged.count(), 1000);
}

#[test]
fn covariance_and_correlation_of_a_hand_sample() {
    let (x, y) = ([1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 4.0, 3.0]);
    assert!((covariance(&x, &y) - 1.0).abs() < 1e-15);
    assert!((correlation(&x, &y) - 0.6).abs() < 1e-15);
    assert_eq!(correlation(&x, &x), 1.0);
    assert!(correlation(&x, &[1.0; 4]).is_nan());
}
