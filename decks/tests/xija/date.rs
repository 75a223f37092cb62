//! Dates that are seconds, and texts that are no dates.

use bmv_decks::xija::date::{YEAR_2000_S, YEAR_S, seconds_since_1998};

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

#[test]
fn days_and_leap_years_are_counted() {
    assert_eq!(seconds_since_1998("1998:001:00:00:00"), Ok(0.0));
    assert_eq!(seconds_since_1998("2000:001:00:00:00"), Ok(YEAR_2000_S));
    assert_eq!(seconds_since_1998("2010:001:00:00:00"), Ok(YEAR_2000_S + 10.0 * YEAR_S));
    // 2000 is a leap year, 1998 and 1999 are none.
    assert_eq!(seconds_since_1998("2001:001:00:00"), Ok((730.0 + 366.0) * DAY_S));
    // The Unix time of 2024-09-03T12:00:00Z is 1725364800, that of 1998-01-01T00:00:00Z is 883612800.
    assert_eq!(seconds_since_1998("2024:247:12:00:00.000"), Ok(1_725_364_800.0 - 883_612_800.0));
    assert_eq!(seconds_since_1998("2024:247"), seconds_since_1998("2024:247:12:00:00"));
    assert_eq!(seconds_since_1998("1997:365:23:59:59.5"), Ok(-0.5));
}

#[test]
fn no_date_is_refused() {
    let wrong =
        ["", "2024", "2024-09-03", "2023:366", "2024:000", "2024:1:00:00:00", "2024:001:24:00:00", "2024:001:00"];
    for text in
        wrong.iter().chain(&["9999:001", "2024:001:00:00:00.", "２０２４:001", "2024:001:00:00:00:00", "+024:001"])
    {
        let message = seconds_since_1998(text).expect_err(text);
        assert!(message.contains("2024:247:12:00:00"), "{message}");
    }
}
