//! Tests of `diagnosis/src/diagnosis/blocks.rs`.

use bmv::diagnosis::blocks::of_held_out;
use bmv::math::functions::ln;

/// Readings that are worth 0.5 independent ones each; one set errs twice as much as the other, in turns.
#[test]
fn log_likelihoods_of_held_out_readings_differ_by_what_unseen_rows_gain() {
    let near: Vec<(f64, f64)> = (0..40).map(|k| (if k % 2 == 0 { 0.1 } else { -0.1 }, 0.5)).collect();
    let far: Vec<(f64, f64)> = near.iter().map(|(error, independent)| (2.0 * error, *independent)).collect();
    let sum = |logs: Vec<f64>| logs.iter().sum::<f64>();
    let gain = sum(of_held_out(&near, 0.1)) - sum(of_held_out(&far, 0.2));
    assert!((gain - 20.0 * ln(2.0)).abs() < 1e-9, "{gain}");
    let [first, second] = of_held_out(&[(0.0, 1.0), (0.3, 1.0)], 0.1)[..] else { panic!("two") };
    assert!((first - second - 4.5).abs() < 1e-9, "three standard deviations cost 4.5");
}
