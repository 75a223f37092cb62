//! Tests of `core/src/statistics/noise.rs`.

use bmv::statistics::noise::noise;

#[test]
fn noise_is_told_from_ramps_and_steps() {
    // A deviation of 0.1 up and down in turn: second differences are 0.4, and 1.4826 * 0.4 / sqrt(6) is 0.2421. Neither a ramp
    // nor a step changes it.
    let other = |row: usize| if row.is_multiple_of(2) { 0.1 } else { -0.1 };
    let values: Vec<f64> =
        (0..40).map(|row| 3.0 * row as f64 + if row < 20 { 0.0 } else { 50.0 } + other(row)).collect();
    assert!((noise(&values).unwrap() - 0.242_108).abs() < 1e-6, "{:?}", noise(&values));
    assert_eq!(noise(&values[..9]), None);
    assert_eq!(noise(&[1.0; 12]), Some(0.0));
}
