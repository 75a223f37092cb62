//! Tests of `core/src/inference/gaussian_process/tested_range.rs`.

use bmv::inference::gaussian_process::tested_range::*;

#[test]
fn every_value_beyond_an_end_is_outside_and_none_within() {
    let range = TestedRange { input: "T".into(), unit: "K".into(), lower: 273.15, upper: 323.15 };
    for (value, outside) in [
        (273.15, false),
        (323.15, false),
        (300.0, false),
        (323.16, true),
        (273.1, true),
        (f64::NAN, true),
        (f64::INFINITY, true),
    ] {
        assert_eq!(range.outside(value).is_some(), outside, "{value}");
    }
    assert_eq!(range.outside(348.15).and_then(|outside| outside.beyond), Some(0.5));
    // One value was tested: every other one is outside.
    let one = TestedRange { input: "q".into(), unit: "W/m^2".into(), lower: 0.0, upper: 0.0 };
    assert!(one.outside(0.0).is_none() && one.outside(1e-3).is_some_and(|outside| outside.beyond.is_none()));
}
