//! How an input goes between the rows of a record: held until the next row, as what a test sets does, or linear.

use crate::report::number::significant;
use crate::statistics::noise::OF_MEDIAN;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Readings below which steps cannot be told from anything else.
const FEWEST: usize = 6;
/// A difference of two rows beyond so many of their standard deviations is a step: of 10,000 normal ones none reaches it.
const STEP: f64 = 6.0;
/// Between steps the readings span at most so many standard deviations of a difference, or this share of the whole range.
const SPAN: f64 = 8.0;
const SHARE_OF_RANGE: f64 = 0.02;
/// Share of the rows in which something that is set may change.
const MOST_CHANGES: f64 = 0.2;
/// Rows that a step may take: a logger that averages shows one value on its way.
const LONGEST_STEP: usize = 2;

/// The rule of an input, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BetweenRows {
    /// Whether each value holds until the next row.
    pub is_held: bool,
    /// What of the readings says so.
    pub because: String,
}

/// The rule that the readings suggest. `unit` is theirs, for the words.
///
/// Differences of neighbouring rows are noise nearly always and large in some rows where something is set: their median
/// tells the noise, whatever the steps are.
pub fn between_rows(readings: &[Option<f64>], unit: &str) -> BetweenRows {
    let linear = |because: String| BetweenRows { is_held: false, because };
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    if known.len() < FEWEST {
        return linear("too few rows to tell steps from ramps".to_owned());
    }
    let differences: Vec<f64> = known.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
    let most = (MOST_CHANGES * differences.len() as f64).floor() as usize;
    let changing: Vec<f64> = differences.iter().copied().filter(|difference| *difference > 0.0).collect();
    if changing.is_empty() {
        return linear("it is the same in all rows".to_owned());
    }
    // Values that change in few rows have no noise: their changes are the steps.
    let noise = if changing.len() <= most { 0.0 } else { OF_MEDIAN * quantile_sorted(&sorted(&changing), 0.5) };
    let is_step: Vec<bool> = differences.iter().map(|difference| *difference > STEP * noise).collect();
    let rows = is_step.iter().filter(|is_step| **is_step).count();
    if rows == 0 {
        let shown = with_unit(quantile_sorted(&sorted(&changing), 0.5), unit);
        return linear(format!("no step stands out of its changes from row to row, {shown} as a rule"));
    }
    if rows > most || longest_run(&is_step) > LONGEST_STEP {
        return linear("it changes over many rows".to_owned());
    }
    let largest = known.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = known.iter().copied().fold(f64::INFINITY, f64::min);
    if widest_between(&known, &is_step) > (SPAN * noise).max(SHARE_OF_RANGE * (largest - smallest)) {
        return linear("it also moves between its steps".to_owned());
    }
    let but = if noise > 0.0 {
        format!(" but for noise of {}", with_unit(noise / 2.0_f64.sqrt(), unit))
    } else {
        String::new()
    };
    let steps = is_step.iter().enumerate().filter(|(row, is)| **is && (*row == 0 || !is_step[row - 1])).count();
    let steps = crate::document::counted(steps, "step");
    BetweenRows { is_held: true, because: format!("it moves in {steps} and stands still between them{but}") }
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 2))
}

/// The most steps in neighbouring rows.
fn longest_run(is_step: &[bool]) -> usize {
    is_step.split(|is_step| !is_step).map(<[bool]>::len).max().unwrap_or(0)
}

/// The widest range of the readings between two steps.
fn widest_between(known: &[f64], is_step: &[bool]) -> f64 {
    let (mut widest, mut range) = (0.0_f64, None::<[f64; 2]>);
    for (row, value) in known.iter().enumerate() {
        let goes_on = row > 0 && is_step.get(row - 1) == Some(&false);
        let [low, high] =
            range.filter(|_| goes_on).map_or([*value; 2], |[low, high]| [low.min(*value), high.max(*value)]);
        widest = widest.max(high - low);
        range = Some([low, high]);
    }
    widest
}
