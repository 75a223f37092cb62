//! Tests of `core/src/statistics/interval.rs`.

use bmv::statistics::interval::*;

fn assert_interval(interval: Interval, lower: f64, upper: f64, tolerance: f64) {
    assert!((interval.lower - lower).abs() < tolerance && (interval.upper - upper).abs() < tolerance, "{interval:?}");
}

#[test]
fn intervals_are_the_published_ones() {
    // Newcombe (1998), table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29; methods 3 (Wilson) and 5 (Clopper-Pearson).
    assert_interval(Interval::wilson(81, 263, 0.95), 0.2553, 0.3662, 5e-5);
    assert_interval(Interval::wilson(15, 148, 0.95), 0.0624, 0.1605, 5e-5);
    assert_interval(Interval::wilson(0, 20, 0.95), 0.0, 0.1611, 5e-5);
    assert_interval(Interval::wilson(1, 29, 0.95), 0.0061, 0.1718, 5e-5);
    assert_interval(Interval::clopper_pearson(81, 263, 0.95), 0.2527, 0.3676, 5e-5);
    assert_interval(Interval::clopper_pearson(15, 148, 0.95), 0.0578, 0.1617, 5e-5);
    assert_interval(Interval::clopper_pearson(0, 20, 0.95), 0.0, 0.1684, 5e-5);
    assert_interval(Interval::clopper_pearson(1, 29, 0.95), 0.0009, 0.1776, 5e-5);
    assert_interval(Interval::normal(10.0, 2.0, 0.95), 6.080_072_03, 13.919_927_97, 1e-8);
    assert_eq!(Interval::wilson(0, 0, 0.9), Interval { lower: 0.0, upper: 1.0 });
    assert_eq!(Interval::clopper_pearson(20, 20, 0.9).upper, 1.0);
}
