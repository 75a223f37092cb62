//! Tests of `core/src/document/calendar.rs`.

use bmv::document::calendar::*;

#[test]
fn dates_are_read_and_written_alike() {
    assert_eq!(days(1970, 1, 1), 0);
    for text in ["1969-12-31 23:59:59", "2000-02-29 00:00:00", "2024-02-29 12:30:15", "2100-03-01 06:07:08"] {
        assert_eq!(dated(text).and_then(date_and_time).as_deref(), Some(text));
    }
    // To the second, over the end of a day and of a year.
    assert_eq!(dated("2026-12-31T23:59:59.7").and_then(date_and_time).as_deref(), Some("2027-01-01 00:00:00"));
    for seconds in [f64::NAN, f64::INFINITY, 1e15, -1e15] {
        assert_eq!(date_and_time(seconds), None);
    }
}
