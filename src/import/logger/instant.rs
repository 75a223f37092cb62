//! Times of a log: ISO 8601, a day's date in figures with points, an epoch, or a count from the start.

use crate::document::calendar::dated;

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
