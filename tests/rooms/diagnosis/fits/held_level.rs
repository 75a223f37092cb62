//! Tests of `diagnosis/src/diagnosis/fits/held_level.rs`.

use bmv::diagnosis::fits::held_level::at_level;

/// A warm-up by 60 K in 60 readings, and so many at its end, K.
fn warm_up(at_end: usize) -> Vec<f64> {
    (0..60).map(|k| 290.0 + f64::from(k)).chain(std::iter::repeat_n(350.0, at_end)).collect()
}

/// A quarter of all, within 2 K: three of a warm-up lie there as well.
#[test]
fn readings_dwell_where_a_quarter_of_them_lie() {
    let there =
        |readings: &[f64], level: f64| at_level(readings, level).map(|at| at.iter().filter(|&&own| own).count());
    assert_eq!(there(&warm_up(18), 350.0), Some(20));
    assert_eq!(there(&warm_up(17), 350.0), None, "19 of 77");
    assert_eq!(there(&warm_up(25), 351.9), Some(25), "a threshold is spread over 2 K to either side");
    assert_eq!(there(&warm_up(25), 352.1), None);
    assert_eq!(there(&warm_up(0), 320.0), None, "evenly spread");
}

/// The band is at most a tenth of the range to either side, so that evenly spread readings never dwell.
#[test]
fn no_narrow_range_dwells_as_a_whole() {
    let evenly: Vec<f64> = (0..101).map(|k| 293.0 + 0.01 * f64::from(k)).collect();
    assert_eq!(at_level(&evenly, 293.5), None, "a range of 1 K");
    assert_eq!(at_level(&[300.0; 9], 300.0), None, "no range");
    assert_eq!(at_level(&[], 300.0), None);
}
