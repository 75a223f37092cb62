//! Tests of `diagnosis/src/diagnosis/verdict/numbers.rs`.

use bmv::diagnosis::verdict::numbers::*;

#[test]
fn sizes_are_read_with_their_errors() {
    assert_eq!(with_error(0.05143, 0.00273), "0.0514 ± 0.0027");
    assert_eq!(with_error(8_680_000.0, 449_161.0), "(8.68 ± 0.45)e6");
    assert_eq!(with_error(-1234.0, 250.0), "(-1.23 ± 0.25)e3");
    assert_eq!(with_error(1.0, 0.0), "1.00 ± 0");
    assert_eq!(with_error(1.0, 1e-8), "1.00 ± 1.0e-8");
    assert_eq!(with_error(f64::NAN, 1.0), "NaN ± 1.0");
    assert_eq!(short(-0.0, 2), "0");
}

#[test]
fn errors_that_fall_by_little_are_told_apart() {
    let shown = |before: f64, after: f64| kelvins_before_and_after([before, after]).join(" ");
    assert_eq!(shown(9.73, 0.409), "9.73 0.41");
    assert_eq!(shown(0.0649, 0.0551), "0.065 0.055");
    assert_eq!(shown(0.1502, 0.1469), "0.150 0.147");
    assert_eq!(shown(0.15, 0.15), "0.15 0.15");
    assert_eq!(shown(0.150_23, 0.150_11), "0.1502 0.1501");
    assert_eq!(shown(1.21e-5, 1.23e-5), "1.2e-5 1.2e-5");
}
