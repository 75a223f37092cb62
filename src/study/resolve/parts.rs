//! Parts of a transient between gaps that are longer than its `max_gap`: each begins anew, since what its inputs did
//! meanwhile is not known.

use std::ops::Range;

/// The name of a part of a transient, from 0 on; the first has the transient's own.
pub fn part_name(transient: &str, part: usize) -> String {
    if part == 0 { transient.to_owned() } else { format!("{transient} (part {})", part + 1) }
}

/// Whether a measurement is what was written under a name, or a part of it.
pub fn belongs_to(measurement: &str, written: &str) -> bool {
    let Some(rest) = measurement.strip_prefix(written) else { return false };
    let number = rest.strip_prefix(" (part ").and_then(|rest| rest.strip_suffix(')'));
    rest.is_empty() || number.is_some_and(|number| number.parse::<usize>().is_ok_and(|number| number > 1))
}

/// Rows of the parts: instants that lie farther apart than `max_gap_s` belong to two. All rows where there is no limit.
pub fn rows_of_parts(times_s: &[f64], max_gap_s: Option<f64>) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut first = 0;
    for row in 1..times_s.len() {
        if max_gap_s.is_some_and(|longest| times_s[row] - times_s[row - 1] > longest) {
            parts.push(first..row);
            first = row;
        }
    }
    parts.push(first..times_s.len());
    parts
}
