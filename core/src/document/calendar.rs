//! Dates and times of day in the Gregorian calendar, as seconds since 1970-01-01.

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// Seconds since 1970-01-01 of a date, perhaps with a time of day: ISO 8601, or a day in figures with points. Of the zone that
/// is named, else of a clock of its own. `None` where it is no date that can be read in one way only.
pub fn dated(text: &str) -> Option<f64> {
    let (date, rest) = match text.find(['T', ' ']) {
        Some(at) => (text.get(..at)?, text.get(at + 1..)?.trim()),
        None => (text, ""),
    };
    let parts = |by: char| -> Option<Vec<i64>> { date.split(by).map(|part| part.parse().ok()).collect() };
    // Day and month in figures with slashes have no order that all countries share: they are not read.
    let (year, month, day) = match (date.contains('-'), date.contains('.'), date.matches('/').count()) {
        (true, ..) => triple(&parts('-')?)?,
        (_, true, _) => {
            let (day, month, year) = triple(&parts('.')?)?;
            (year, month, day)
        }
        (_, _, 2) if date.find('/') == Some(4) => triple(&parts('/')?)?,
        _ => return None,
    };
    if !(1900..3000).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let (clock, offset) = zone(rest)?;
    Some(days(year, month, day) as f64 * DAY_S + seconds(clock)? - offset)
}

fn triple(parts: &[i64]) -> Option<(i64, i64, i64)> {
    match parts {
        &[a, b, c] => Some((a, b, c)),
        _ => None,
    }
}

/// A clock's reading, and how far its zone is ahead of UTC, s.
fn zone(text: &str) -> Option<(&str, f64)> {
    let text = text.trim();
    if let Some(clock) = text.strip_suffix(['Z', 'z']) {
        return Some((clock.trim(), 0.0));
    }
    if let Some(clock) = text.strip_suffix("UTC") {
        return Some((clock.trim(), 0.0));
    }
    let Some(at) = text.rfind(['+', '-']) else { return Some((text, 0.0)) };
    let ahead = text.get(at + 1..)?.replace(':', "");
    let number: f64 = ahead.parse().ok()?;
    let offset = match ahead.len() {
        1 | 2 => number * 3600.0,
        4 => (number / 100.0).trunc() * 3600.0 + (number % 100.0) * 60.0,
        _ => return None,
    };
    Some((text.get(..at)?.trim(), if text.as_bytes().get(at) == Some(&b'-') { -offset } else { offset }))
}

/// Seconds of a day; of no text none.
fn seconds(clock: &str) -> Option<f64> {
    if clock.is_empty() {
        return Some(0.0);
    }
    let parts: Option<Vec<f64>> = clock.split(':').map(|part| part.parse().ok()).collect();
    let (hour, minute, second) = match *parts?.as_slice() {
        [hour, minute] => (hour, minute, 0.0),
        [hour, minute, second] => (hour, minute, second),
        _ => return None,
    };
    let is_clock = (0.0..=24.0).contains(&hour) && (0.0..60.0).contains(&minute) && (0.0..61.0).contains(&second);
    is_clock.then_some(3600.0 * hour + 60.0 * minute + second)
}

/// Days from 1970-01-01 to a day of the Gregorian calendar (E. G. Richards, Calendars, in: Explanatory Supplement to the
/// Astronomical Almanac, 3rd edition, 2013, section 15.11: the Julian day number, here less that of 1970-01-01).
pub fn days(year: i64, month: i64, day: i64) -> i64 {
    let before_march = (14 - month) / 12;
    let year = year + 4800 - before_march;
    let month = month + 12 * before_march - 3;
    day + (153 * month + 2) / 5 + 365 * year + year / 4 - year / 100 + year / 400 - 32_045 - 2_440_588
}

/// A date and time to the second, as `2026-03-14 17:12:05`; none beyond the years of four figures.
pub fn date_and_time(seconds: f64) -> Option<String> {
    let whole = seconds.round();
    let day = (whole / DAY_S).floor();
    if !(-719_000.0..2_932_000.0).contains(&day) {
        return None;
    }
    let (year, month, date) = civil(day as i64);
    let of_day = (whole - day * DAY_S) as i64;
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    Some(format!("{year:04}-{month:02}-{date:02} {hour:02}:{minute:02}:{second:02}"))
}

/// Year, month and day of a day counted from 1970-01-01 (the inverse of [`days`], from the same source).
fn civil(days: i64) -> (i64, i64, i64) {
    let f = days + 2_440_588 + 1401 + ((4 * (days + 2_440_588) + 274_277) / 146_097 * 3) / 4 - 38;
    let e = 4 * f + 3;
    let h = 5 * ((e % 1461) / 4) + 2;
    let day = (h % 153) / 5 + 1;
    let month = (h / 153 + 2) % 12 + 1;
    (e / 1461 - 4716 + (14 - month) / 12, month, day)
}
