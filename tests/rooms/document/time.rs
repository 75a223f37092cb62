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
