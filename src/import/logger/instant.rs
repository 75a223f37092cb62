//! Times of a log: ISO 8601, a day's date in figures with points, an epoch, or a count from the start.

/// Numbers above are milliseconds since 1970, those above the second are seconds since 1970.
const EPOCH_MS: f64 = 1.0e11;
/// 1973 in seconds since 1970: no log counts so many seconds from its own start.
const EPOCH_S: f64 = 1.0e8;

/// An instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instant {
    /// Seconds since 1970-01-01, of the zone that the log names, else of its own clock.
    Dated(f64),
    /// A count from the start, in the column's unit.
    Counted(f64),
}

/// The instant of a cell; `None` where it is no time that can be read in one way only.
pub fn instant(cell: &str, has_comma: bool) -> Option<Instant> {
    let written = if has_comma { cell.replace(',', ".") } else { cell.to_owned() };
    if let Ok(number) = written.parse::<f64>() {
        return match number {
            n if !n.is_finite() => None,
            n if n >= EPOCH_MS => Some(Instant::Dated(n / 1000.0)),
            n if n >= EPOCH_S => Some(Instant::Dated(n)),
            n => Some(Instant::Counted(n)),
        };
    }
    dated(&written).map(Instant::Dated)
}

fn dated(text: &str) -> Option<f64> {
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
    Some(days(year, month, day) as f64 * 86_400.0 + seconds(clock)? - offset)
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
