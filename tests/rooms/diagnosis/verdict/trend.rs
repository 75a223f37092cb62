//! Tests of `diagnosis/src/diagnosis/verdict/trend.rs`.

use bmv::diagnosis::verdict::trend::*;

#[test]
fn ranks_of_equal_values_are_shared_and_a_ramp_follows_time() {
    assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [2.5, 0.0, 2.5, 1.0]);
    let times: Vec<f64> = (0..40).map(f64::from).collect();
    let decaying: Vec<f64> = times.iter().map(|t| 100.0 / (1.0 + t)).collect();
    assert!((correlation(&ranks(&decaying), &ranks(&times)) + 1.0).abs() < 1e-12);
    let cycles: Vec<f64> = times.iter().map(|t| f64::from(u8::from(t % 10.0 < 4.0))).collect();
    assert!(correlation(&ranks(&cycles), &ranks(&times)).abs() < 0.3);
    assert_eq!(correlation(&ranks(&[1.0; 9]), &ranks(&times[..9])), 0.0);
}
