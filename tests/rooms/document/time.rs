//! Tests of `core/src/document/time.rs`.

use bmv::document::time::*;

#[test]
fn times_are_stated_in_the_unit_that_keeps_them_short() {
    let units = [0.0, 600.0, -601.0, 7200.0, 7201.0, 259_200.0, 259_201.0].map(|time_s| unit_of_time(time_s).1);
    assert_eq!(units, ["s", "s", "min", "min", "h", "h", "d"]);
    assert_eq!(instant(380_000.0, 3_801_600.0), "4.4 d");
    assert_eq!(instant(57.28, 300.0), "57.3 s");
    assert_eq!(instant(-0.001, 300.0), "0 s");
}

#[test]
fn stretches_of_one_record_share_a_unit_and_are_told_apart() {
    assert_eq!(stretch(0.0, 380_160.0, 3_801_600.0), "0 to 4.4 d");
    assert_eq!(stretch(380_160.0, 760_320.0, 3_801_600.0), "4.4 to 8.8 d");
    assert_eq!(stretch(380_160.0, 380_760.0, 3_801_600.0), "4.4 to 4.4069 d");
    assert_eq!(stretch(10.0, 120.0, 120.0), "10 to 120 s");
    assert_eq!(stretch(12_600.0, 12_600.0, 36_000.0), "at 3.5 h");
    assert_eq!(stretch(f64::NAN, 1.0, 10.0), "NaN to 1 s");
}

#[test]
fn slow_changes_are_stated_by_the_hour_day_or_year() {
    let stated = |unit: &str, size: f64| unit_of_rate(unit, size).map(|(length, unit)| (size * length, unit));
    let (drift, unit) = stated("K/s", -1e-5).expect("a slow drift");
    assert!((drift + 0.864).abs() < 1e-12 && unit == "K/d", "{drift} {unit}");
    let (growth, unit) = stated("1/s", 3.2e-9).expect("a slow growth");
    assert!((growth - 0.100_984_32).abs() < 1e-9 && unit == "1/yr", "{growth} {unit}");
    assert_eq!(stated("K/s", 1e-3).expect("a drift").1, "K/h");
    for (unit, size) in [("K/s", 0.02), ("K/s", 0.0), ("K/s", f64::NAN), ("K/h", 1e-5), ("kg/s", 1e-5), ("m2/s", 1e-7)]
    {
        assert_eq!(stated(unit, size), None, "{size} {unit}");
    }
}
