//! Channels that died in the course of a record: without a reading from some row on, or at one value while the others move.

use super::record::{Channel, Record};
use crate::document::counted;
use crate::document::time::{instant, unit_of_time};
use crate::report::number::as_given;

/// Rows at the end without a reading from which a channel counts as dead.
const FEWEST_MISSING: usize = 3;
/// Rows at the end with one value from which a temperature counts as stuck.
const FEWEST_STUCK: usize = 20;
/// Times the longest such run before it that the one at the end takes.
const LONGER: usize = 5;
/// Of its own smallest steps, by how many most other temperatures move meanwhile.
const STEPS: f64 = 5.0;

/// How a channel ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Without a reading from this row on.
    Missing(usize),
    /// At one value from this row on.
    Stuck(usize, f64),
}

/// Lengths of the runs of rows for which something holds, the last one apart where it reaches the end.
fn runs(holds: impl Iterator<Item = bool>) -> (usize, usize) {
    let (mut longest, mut own) = (0, 0);
    for holds in holds {
        if holds {
            own += 1;
        } else {
            longest = longest.max(own);
            own = 0;
        }
    }
    (longest, own)
}

/// How a channel ended before the record did; `None` where it did not.
pub fn end(record: &Record, at: usize) -> Option<End> {
    let channel = &record.channels[at];
    let rows = channel.readings.len();
    let (before, missing) = runs(channel.readings.iter().map(Option::is_none));
    if missing == rows {
        return None;
    }
    if missing >= FEWEST_MISSING && missing > LONGER * before {
        return Some(End::Missing(rows - missing));
    }
    // Readings with their rows: a logger may read the channel in some rows only.
    let known: Vec<(usize, f64)> =
        channel.readings.iter().enumerate().filter_map(|(row, value)| Some((row, (*value)?))).collect();
    let (before, same) = runs(known.windows(2).map(|two| two[0].1 == two[1].1));
    let steps = known.windows(2).map(|two| (two[1].1 - two[0].1).abs()).filter(|step| *step > 0.0);
    let smallest = steps.reduce(f64::min)?;
    if !channel.is_temperature() || same < FEWEST_STUCK || same < LONGER * before {
        return None;
    }
    let (from, value) = known[known.len() - 1 - same];
    let moves = |other: &Channel| {
        let readings = || other.readings[from..].iter().flatten().copied();
        readings().reduce(f64::max).unwrap_or(0.0) - readings().reduce(f64::min).unwrap_or(0.0) > STEPS * smallest
    };
    let is_other = |(place, other): &(usize, &Channel)| *place != at && other.is_temperature() && !other.is_stuck();
    let others: Vec<bool> =
        record.channels.iter().enumerate().filter(is_other).map(|(_, other)| moves(other)).collect();
    let moving = others.iter().filter(|moves| **moves).count();
    (2 * moving > others.len()).then_some(End::Stuck(from, value))
}

/// The record without what stuck channels went on to show, and what to know of each channel that died; `kept` are those whose
/// readings all stay.
pub fn without(record: &Record, kept: &[String]) -> (Record, Vec<String>) {
    let (mut out, mut notes) = (record.clone(), Vec::new());
    for (at, channel) in record.channels.iter().enumerate() {
        if channel.left_out.is_some() || kept.contains(&channel.name) {
            continue;
        }
        let Some(end) = end(record, at) else { continue };
        let (End::Missing(row) | End::Stuck(row, _)) = end;
        let seconds = record.times_s[row];
        let from = match unit_of_time(seconds) {
            (_, "s") => format!("{seconds} s on"),
            _ => format!("{seconds} s ({}) on", instant(seconds, seconds)),
        };
        let (name, rows) = (&channel.name, counted(channel.readings.len() - row, "row"));
        notes.push(match end {
            End::Missing(_) => format!(
                "channel `{name}` has no reading from {from}, in the last {rows}: what it read before stays, and its last readings may \
                 be wrong already; \"ignore\": {{\"{name}\": \"died at {seconds} s\"}} beside \"sensors\" leaves the sensor out altogether",
            ),
            End::Stuck(_, value) => format!(
                "channel `{name}` stays at {} from {from}, in the last {rows}, while the others move, as if it had come loose or its \
                 converter hung: these readings are left out of the file; --keep '{name}' keeps them, and \"ignore\": {{\"{name}\": \
                 \"stuck from {seconds} s on\"}} beside \"sensors\" leaves the sensor out altogether",
                as_given(value)
            ),
        });
        if let End::Stuck(..) = end {
            out.channels[at].readings[row..].fill(None);
        }
    }
    (out, notes)
}
