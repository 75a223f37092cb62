//! Tests of `core/src/math/sum.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::sum::*;

#[test]
fn compensation_keeps_what_plain_sums_lose() {
    let values = [1.0, 1e100, 1.0, -1e100];
    assert_eq!(ordered(&values), 0.0);
    assert_eq!(compensated(values), 2.0);
    // A tenth ten million times: the plain sum is off by 1e-4.
    let sum = compensated(std::iter::repeat_n(0.1, 10_000_000));
    assert!((sum - 1e6).abs() < 1e-9, "{sum}");
    assert_eq!(compensated([f64::INFINITY, 1.0]), f64::INFINITY);
}

#[test]
fn merged_sums_equal_one_sum() {
    let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.7).sin() * 1e8 + 1e-8).collect();
    let whole: CompensatedSum = values.iter().copied().collect();
    let mut merged: CompensatedSum = values[..333].iter().copied().collect();
    merged.merge(&values[333..].iter().copied().collect());
    assert!((whole.value() - merged.value()).abs() < 1e-14 * 1e8);
}

#[test]
fn log_sum_exp_survives_large_and_small_terms() {
    assert!((log_sum_exp(&[1000.0, 1000.0]) - 1_000.693_147_180_56).abs() < 1e-12);
    assert!((log_sum_exp(&[-2000.0, -2001.0]) + 1_999.686_738_312_8).abs() < 1e-9);
    assert_eq!(log_sum_exp(&[]), f64::NEG_INFINITY);
    assert_eq!(log_sum_exp(&[f64::NEG_INFINITY; 2]), f64::NEG_INFINITY);
    assert!(log_sum_exp(&[1.0, f64::NAN]).is_nan());
}
