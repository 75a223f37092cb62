//! Tests of `src/report/number.rs`.

use bmv::report::number::*;

#[test]
fn zero_has_no_sign_and_minus_is_a_minus() {
    assert_eq!(fixed(-0.001, 2), "0.00");
    assert_eq!(fixed(-1.5, 1), "\u{2212}1.5");
    assert_eq!(signed(0.0004, 2), "0.00");
    assert_eq!(signed(0.4, 2), "+0.40");
    assert_eq!(fixed(f64::NAN, 2), NONE);
}

#[test]
fn digits_follow_the_error() {
    assert_eq!(with_error(28.9123, 0.0654), "28.912 \u{00B1} 0.065");
    assert_eq!(with_error(1234.5, 23.0), "1234 \u{00B1} 23");
    assert_eq!(with_error(1234.5, 230.0), "1230 \u{00B1} 230");
    assert_eq!(with_error(9.0, 912.0), "10 \u{00B1} 910");
    assert_eq!(with_error(133.5, 12345.0), "0 \u{00B1} 12000");
    assert_eq!(with_error(28.9123, f64::NAN), "28.91");
}

#[test]
fn significant_digits_and_powers_of_ten() {
    assert_eq!(significant(0.012345, 3), "0.0123");
    assert_eq!(significant(123456.0, 3), "123456");
    assert_eq!(significant(1.0e-9, 2), "1.0\u{00A0}\u{00D7}\u{00A0}10\u{207B}\u{2079}");
    assert_eq!(significant(0.0, 3), "0");
    assert_eq!(significant(9.999, 2), "10");
    assert_eq!(
        (as_given(0.85).as_str(), as_given(100.0).as_str(), as_given(-40.25).as_str()),
        ("0.85", "100", "\u{2212}40.25")
    );
    assert_eq!(as_given(1.0e-5), "1\u{00A0}\u{00D7}\u{00A0}10\u{207B}\u{2075}");
}

#[test]
fn temperatures_are_celsius_and_their_differences_kelvin() {
    let shown = Shown::quantity("K", true);
    assert_eq!(shown.text(308.15), "35.00\u{00A0}\u{00B0}C");
    assert_eq!(shown.difference().text(4.19), "4.19\u{00A0}K");
    assert_eq!(Shown::quantity("K", false).text(4.0), "4.00\u{00A0}K");
}

#[test]
fn units_are_typeset() {
    assert_eq!(typeset("W/m2"), "W/m\u{00B2}");
    assert_eq!(typeset("W/K^1.25"), "W/K^1.25");
    assert_eq!(typeset("m^-1"), "m\u{207B}\u{00B9}");
    assert_eq!(typeset("1"), "");
}

#[test]
fn probabilities_near_one_keep_their_rest() {
    assert_eq!(probability(0.99987), "0.99987");
    assert_eq!(probability(0.9187), "0.919");
    assert_eq!(probability(1.0), "1.000");
}

#[test]
fn times_have_the_unit_that_suits_the_longest_of_them() {
    let day = Shown::time(5.0 * 86_400.0);
    assert_eq!((day.value(43_200.0), day.unit.as_str()), (0.5, "d"));
    assert_eq!(Shown::time(30.0).text(30.0), "30.00\u{A0}s");
    assert_eq!(Shown::time(5400.0).text(5400.0), "90.00\u{A0}min");
}
