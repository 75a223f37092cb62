//! Stretches without rows in a transient: what its inputs did meanwhile is not known.

use crate::document::{Diagnostic, Place, code};
use crate::math::sort::sort_by;
use crate::measurement::{Doubt, Measurement, Rows};

use super::plausible::short;
use super::scope::Scope;

/// Times the usual distance between rows from which one is a gap.
const LONGER: f64 = 20.0;
/// Times the shortest of the distances before it, and of those after it, from which one is a gap: rows that get rarer, as those of a
/// cooling after a step that are spaced evenly in the logarithm of time, have none.
const LONGER_THAN_BESIDE: f64 = 4.0;
/// Distances before and after that are asked.
const BESIDE: usize = 3;
/// Least share of the whole record that a gap takes.
const LEAST_SHARE: f64 = 0.02;
/// Gaps named in a message.
const NAMED: usize = 3;

/// Says where the rows of a transient whose inputs vary have gaps.
pub(super) fn doubts(scope: &mut Scope, measurement: &mut Measurement, place: &Place) {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return };
    if inputs.columns.is_empty() {
        return;
    }
    let gaps = gaps(&inputs.times_s);
    if gaps.is_empty() {
        return;
    }
    let mut named: Vec<String> =
        gaps.iter().take(NAMED).map(|[from, to]| format!("{} to {} s", short(*from), short(*to))).collect();
    if gaps.len() > NAMED {
        named.push(format!("{} more", gaps.len() - NAMED));
    }
    let message = format!(
        "`{}` has no rows for more than {LONGER} times their usual distance ({}): its inputs are taken to go straight from one row to the next, or to stay where they are held",
        measurement.name,
        named.join(", ")
    );
    let help = "if the inputs really did that, change nothing; otherwise \"max_gap\", with \"initial\": {\"measured\": {}}, lets each part begin anew, or \
                `ignore` leaves out the rows after the gap in which its effect still shows, with the reason";
    let doubt = Diagnostic::warning(&code::GAP, place, message).help(help);
    measurement.doubts.push(Doubt::from(&doubt));
    scope.doubts.push(doubt);
}

/// The gaps between ascending instants, each with its ends.
pub fn gaps(times_s: &[f64]) -> Vec<[f64; 2]> {
    let steps: Vec<f64> = times_s.windows(2).map(|two| two[1] - two[0]).collect();
    let mut ascending = steps.clone();
    sort_by(&mut ascending, f64::total_cmp);
    let (Some(&usual), Some(first), Some(last)) = (ascending.get(steps.len() / 2), times_s.first(), times_s.last())
    else {
        return Vec::new();
    };
    let least = (LONGER * usual).max(LEAST_SHARE * (last - first));
    let stands_out = |place: usize| {
        let (before, after) = (&steps[place.saturating_sub(BESIDE)..place], &steps[place + 1..]);
        let shortest = |beside: &[f64]| beside.iter().copied().reduce(f64::min);
        match (shortest(before), shortest(&after[..BESIDE.min(after.len())])) {
            (Some(before), Some(after)) => steps[place] > LONGER_THAN_BESIDE * before.max(after),
            // At an end nothing on the other side says that rows get rarer.
            (Some(beside), None) | (None, Some(beside)) => steps[place] > LONGER * beside,
            (None, None) => false,
        }
    };
    let is_gap = |place: &usize| steps[*place] > least && stands_out(*place);
    (0..steps.len()).filter(is_gap).map(|place| [times_s[place], times_s[place + 1]]).collect()
}
