//! Dates by year and day of the year, as xija writes them: `2024:247:12:00:00`.

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// Seconds from 1998-01-01T00:00:00 to 2000-01-01T00:00:00: two years of 365 days.
pub const YEAR_2000_S: f64 = 730.0 * DAY_S;

/// Seconds in a year, as xija has it: a tenth of the ten years from 2000 on.
pub const YEAR_S: f64 = 3653.0 * DAY_S / 10.0;

/// Seconds from 1998-01-01T00:00:00 to a date `YYYY:DDD`, `YYYY:DDD:hh:mm`, `YYYY:DDD:hh:mm:ss` or with a fraction of
/// the second; a date without a time of day is noon, as in Chandra.Time.
///
/// Days have 86 400 s: no leap seconds are counted. Chandra's clock counts them, and from Terrestrial Time, so that it is
/// ahead by 63.184 s in 1998 and by 69.184 s from 2017 on.
///
/// # Errors
/// A text of another form, or a day or time that does not exist.
pub fn seconds_since_1998(text: &str) -> Result<f64, String> {
    let wrong = || format!("`{text}` is no date; write year, day of the year and time as in 2024:247:12:00:00");
    let parts: Vec<&str> = text.trim().split(':').collect();
    let whole = |part: &str, digits: usize| -> Result<u32, String> {
        let all_digits = part.len() == digits && part.bytes().all(|byte| byte.is_ascii_digit());
        if all_digits { part.parse().map_err(|_| wrong()) } else { Err(wrong()) }
    };
    let (date, clock) = match parts.as_slice() {
        [year, day] => ([*year, *day], ["12", "00", "00"]),
        [year, day, hour, minute] => ([*year, *day], [*hour, *minute, "00"]),
        [year, day, hour, minute, second] => ([*year, *day], [*hour, *minute, *second]),
        _ => return Err(wrong()),
    };
    let (year, day) = (whole(date[0], 4)?, whole(date[1], 3)?);
    let (hour, minute) = (whole(clock[0], 2)?, whole(clock[1], 2)?);
    let (second, fraction) = clock[2].split_once('.').unwrap_or((clock[2], "0"));
    let second = whole(second, 2)?;
    let fraction: f64 = match fraction.len() {
        1..=9 => f64::from(whole(fraction, fraction.len())?) / fraction.bytes().fold(1.0, |power, _| power * 10.0),
        _ => return Err(wrong()),
    };
    let leap = |year: u32| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days_of_year = if leap(year) { 366 } else { 365 };
    // 60 is a leap second.
    if !(1990..=2200).contains(&year) || !(1..=days_of_year).contains(&day) || hour > 23 || minute > 59 || second > 60 {
        return Err(wrong());
    }
    let leap_days = |before: u32| (before - 1) / 4 - (before - 1) / 100 + (before - 1) / 400;
    let years = f64::from(year) - 1998.0;
    let days = years * 365.0 + f64::from(leap_days(year)) - f64::from(leap_days(1998)) + f64::from(day - 1);
    Ok(days * DAY_S + f64::from(hour) * 3600.0 + f64::from(minute) * 60.0 + f64::from(second) + fraction)
}
