//! Tests of `src/import/logger/instant.rs`.

use bmv::import::logger::instant::*;

#[test]
fn times_of_all_kinds() {
    // date -u -d 2024-02-29T12:30:15Z +%s
    let leap = 1_709_209_815.0;
    for text in [
        "2024-02-29T12:30:15Z",
        "2024-02-29 12:30:15",
        "29.02.2024 12:30:15",
        "2024-02-29T14:30:15+02:00",
        "2024/02/29 12:30:15",
        "1709209815",
        "1709209815000",
    ] {
        assert_eq!(instant(text, false), Some(Instant::Dated(leap)), "{text}");
    }
    assert_eq!(instant("2024-02-29 12:30:15,250", true), Some(Instant::Dated(leap + 0.25)));
    assert_eq!(instant("12,5", true), Some(Instant::Counted(12.5)));
    for text in ["03/04/2024 10:00", "yesterday", "2024-13-01", "", "2024-01-01 25:99"] {
        assert_eq!(instant(text, false), None, "{text}");
    }
}
