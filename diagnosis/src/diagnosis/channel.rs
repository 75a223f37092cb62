//! What a channel shows by itself beside a fit: spikes and drop-outs, stretches of one value in a transient and in steady phases, and
//! near which rows an input steps.

use std::ops::Range;

use crate::diagnosis::together::{LONGEST_ANSWER, are_alike};
use crate::math::functions::{pow, sqrt};
use crate::measurement::{InputColumn, InputTable};
use crate::statistics::quantile::quantile_sorted;

/// Rows to either side of which the median is what a spike stands out from.
const BESIDE: usize = 4;
/// Rows to a side whose distances tell how much a channel moves at a time of the record: by day more than by night.
const ABOUT: usize = 25;
/// Share of an input's range, and times its median change from row to row, by which it steps.
const STEP_SHARE: f64 = 0.2;
const STEP_TIMES: f64 = 10.0;
/// Rows before and after a step of an input in which a reading may rightly jump and come back.
const BEFORE_STEP: usize = 1;
const AFTER_STEP: usize = 2;
/// Least height of a spike, in robust standard deviations of such distances: normal noise has one of it in 10^15 readings.
const SPIKE: f64 = 8.0;
/// Share of its height to which a spike comes back.
const COMES_BACK: f64 = 0.25;
/// Most readings of a sensor, as a share, that are taken for faults of a transient.
const MOST_OF_TRANSIENT: f64 = 0.05;
/// Fewest readings of a stretch of one value that is taken for frozen.
const LEAST_RUN: f64 = 8.0;
/// Fewest readings of one value that show a channel's resolution, and fewest changes between such stretches.
const LEAST_HELD: usize = 3;
/// Share of a channel's step by which changes of whole steps may differ from multiples of it.
const OF_A_STEP: f64 = 0.1;
/// Fewest rows on a side of a stretch of one value that show whether a channel has noise in every row.
const LEAST_BESIDE: usize = 40;
/// Largest share of successive readings that repeat, and least share of changes of the errors that turn back, where noise shows in every row.
/// Of independent noise two thirds turn. Eight readings of one value then come by chance once in 10^9.
const REPEATS: f64 = 0.05;
const TURNS: f64 = 1.0 / 3.0;
/// Share of a channel's changes that its errors have at least, where it is noise and not what the model predicts.
const UNEXPLAINED: f64 = 1.0 / 3.0;
/// Times that such a stretch is longer than nine of ten stretches of the channel.
const LONGER_RUN: f64 = 4.0;
/// The model moves meanwhile by this many typical changes of its error and steps of the channel.
const MOVES: f64 = 8.0;
/// And by this many of its errors elsewhere, in robust standard deviations: a model that errs as much tells nothing, and a plateau may be
/// what it lacks, such as melting or a thermostat.
const BEYOND_ERRORS: f64 = 4.0;
/// Campaigns of which one has a stretch of steady phases that is taken for stuck, where the noise is as stated.
const STUCK: f64 = 1e5;
/// Largest resolution of a channel that may be stuck in steady phases, in standard deviations of its noise.
const FINE: f64 = 0.1;
/// Most readings of a sensor, as a share, that are taken for those of a frozen channel.
const MOST_FROZEN: f64 = 0.5;
/// Standard deviation of a normal variable in its median absolute deviations.
pub(crate) const MEDIAN_TO_SD: f64 = 1.482_602_218_505_602;
/// Share of a jump of the error that the channel itself must show.
const LEAST_OF_JUMP: f64 = 0.5;

/// The median; `None` of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| quantile_sorted(&values, 0.5))
}

/// The step of a channel whose readings mostly repeat the one before: the smallest change that came often, of which most changes are
/// multiples. 0 where readings do not repeat, or change by any amount.
pub fn resolution(readings: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        readings.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0).collect();
    if 2 * steps.len() >= readings.len() {
        return 0.0;
    }
    steps.sort_by(f64::total_cmp);
    let is_multiple = |step: f64, of: f64| (step / of - (step / of).round()).abs() < OF_A_STEP;
    let is_step = |&of: &f64| 2 * steps.iter().filter(|step| is_multiple(**step, of)).count() >= steps.len();
    let alike = steps.chunk_by(|a, b| b - a < OF_A_STEP * a).filter(|alike| alike.len() >= LEAST_HELD);
    alike.map(|alike| alike[alike.len() / 2]).find(is_step).unwrap_or(0.0)
}

/// A sensor's errors, row by row, what it showed, and how much it moves.
pub(crate) struct Channel<'a> {
    errors: &'a [f64],
    readings: &'a [f64],
    /// Distance of each error to the median of those about it.
    distances: Vec<f64>,
    /// Least height of a spike anywhere in it.
    of_all: f64,
}

impl<'a> Channel<'a> {
    /// A channel by its errors and readings, one a row.
    pub fn new(errors: &'a [f64], readings: &'a [f64]) -> Self {
        let mut channel = Self { errors, readings, distances: Vec::new(), of_all: 0.0 };
        channel.distances = (0..errors.len()).map(|at| (errors[at] - channel.beside(at, at + 1)).abs()).collect();
        let steps = readings.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
        // A channel that shows whole steps does not stand out by one.
        let finest = steps.fold(f64::INFINITY, f64::min);
        let least_step = if finest.is_finite() { finest.max(resolution(readings)) } else { 0.0 };
        let of_all = MEDIAN_TO_SD * median(channel.distances.clone()).unwrap_or(0.0);
        channel.of_all = SPIKE * of_all.max(0.5 * least_step);
        channel
    }

    /// Standard deviation of its distances from what is beside them.
    pub fn sd(&self) -> f64 {
        self.of_all / SPIKE
    }

    /// The median of the errors of a few rows before and after a stretch.
    fn beside(&self, at: usize, until: usize) -> f64 {
        let before = self.errors[at.saturating_sub(BESIDE)..at].iter();
        let after = &self.errors[until..self.errors.len().min(until + BESIDE)];
        median(before.chain(after).copied().collect()).unwrap_or(0.0)
    }

    /// Least height of a spike in a row.
    fn least_at(&self, at: usize) -> f64 {
        // Of the rows before and after the livelier: a channel begins to move at once.
        let until = self.distances.len().min(at + ABOUT + 1);
        let sides = [&self.distances[at.saturating_sub(ABOUT)..=at], &self.distances[at..until]];
        let [before, after] = sides.map(|side| median(side.to_vec()).unwrap_or(0.0));
        self.of_all.max(SPIKE * MEDIAN_TO_SD * before.max(after))
    }

    /// The jump of the error from a row to the next, where the channel jumps and not the model alone: a start, or a sensor that
    /// follows late.
    fn jump(&self, at: usize) -> f64 {
        let jump = self.errors[at + 1] - self.errors[at];
        let is_own = (self.readings[at + 1] - self.readings[at]) / jump > LEAST_OF_JUMP;
        if is_own { jump } else { 0.0 }
    }

    /// Spikes and drop-outs: positions, and the largest distance from what is beside them.
    pub fn spikes(&self) -> Vec<(Range<usize>, f64)> {
        let (errors, readings, n) = (self.errors, self.readings, self.errors.len());
        if n < 4 * BESIDE {
            return Vec::new();
        }
        let most = (MOST_OF_TRANSIENT * n as f64) as usize;
        let mut found: Vec<(Range<usize>, f64)> = Vec::new();
        let mut at = 1;
        while at + 1 < n {
            let jump = self.jump(at - 1).abs();
            if !(jump > self.of_all && jump > self.least_at(at)) {
                at += 1;
                continue;
            }
            let least = self.least_at(at);
            // A longer stretch would be more than the share that is allowed.
            let frozen = readings[at..].iter().take(most).take_while(|value| **value == readings[at]).count();
            let longest = frozen.max(LONGEST_ANSWER);
            // It comes back to where it was.
            let is_back = |until: &usize| {
                let level = self.beside(at, *until);
                let back = (errors[*until] - level).abs();
                // The model's own error moves on meanwhile.
                back < f64::max(0.5 * least, COMES_BACK * (errors[at] - level).abs())
                    && (at..*until).all(|row| (errors[row] - level).abs() > least)
            };
            match (at + 1..n.min(at + longest + 1)).find(is_back) {
                Some(until) => {
                    let level = self.beside(at, until);
                    let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
                    found.push((at..until, (at..until).map(|row| errors[row] - level).fold(0.0, largest)));
                    at = until + 1;
                }
                None => at += 1,
            }
        }
        if found.iter().map(|(rows, _)| rows.len()).sum::<usize>() > most { Vec::new() } else { found }
    }

    /// Whether it moves the same way as a jump of this height about a position, be it by half of what makes a spike: where to look is
    /// known. It need not come back as soon.
    pub fn answers(&self, at: usize, by: f64) -> bool {
        let is_answer = |&before: &usize| {
            let jump = self.jump(before);
            are_alike(jump, by) && jump.abs() > 0.5 * self.of_all.max(self.least_at(before + 1))
        };
        let last = (at + 1).min(self.errors.len().saturating_sub(1));
        self.errors.len() >= 4 * BESIDE && (at.saturating_sub(2)..last).any(|before| is_answer(&before))
    }
}

/// Positions of spikes and drop-outs in a sensor's errors, row by row; `readings` are what it showed.
pub fn spikes(errors: &[f64], readings: &[f64]) -> Vec<usize> {
    Channel::new(errors, readings).spikes().into_iter().flat_map(|(rows, _)| rows).collect()
}

/// Rows at which an input steps: it changes by much of its range, and by far more than it does from row to row otherwise.
pub fn input_steps(inputs: &InputTable) -> Vec<usize> {
    let of_column = |column: &InputColumn| -> Vec<usize> {
        let changes: Vec<f64> = column.values.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
        let [least, most] = (column.values.iter())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &value| [value.min(least), value.max(most)]);
        let usual = median(changes.clone()).unwrap_or(0.0);
        let is_step = |change: f64| change > STEP_SHARE * (most - least) && change > STEP_TIMES * usual;
        (0..changes.len()).filter(|&row| is_step(changes[row])).map(|row| row + 1).collect()
    };
    let mut rows: Vec<usize> = inputs.columns.iter().flat_map(of_column).collect();
    rows.sort_unstable();
    rows.dedup();
    rows
}

/// Whether a row is near one of these, which ascend.
pub(crate) fn is_near_step(steps: &[usize], row: usize) -> bool {
    let next = steps.partition_point(|&step| step + AFTER_STEP < row);
    steps.get(next).is_some_and(|&step| step <= row + BEFORE_STEP)
}

/// Whether a channel's noise shows in every row beside a stretch of one value, on each side that has rows enough: readings hardly repeat,
/// change half as much as elsewhere at least (`usual`, the median), their errors turn back, and change a third as much at least. What comes to rest by
/// itself is approached by ever smaller changes, and what a heater or the weather moves, the model moves too.
fn shows_noise_beside(errors: &[f64], readings: &[f64], (first, length): (usize, usize), usual: f64) -> bool {
    let span = length.max(LEAST_BESIDE);
    let after = first + length - 1;
    let sides = [first.saturating_sub(span)..first + 1, after..readings.len().min(after + span + 1)];
    let is_noisy = |side: &Range<usize>| {
        let changes_of =
            |values: &[f64]| -> Vec<f64> { values[side.clone()].windows(2).map(|two| two[1] - two[0]).collect() };
        let typical_of = |changes: &[f64]| median(changes.iter().map(|change| change.abs()).collect()).unwrap_or(0.0);
        let [shown, of_errors] = [readings, errors].map(changes_of);
        let repeats = shown.iter().filter(|change| **change == 0.0).count() as f64;
        let turns = of_errors.windows(2).filter(|two| two[0] * two[1] < 0.0).count() as f64;
        let typical = typical_of(&shown);
        (repeats + 1.0) / (shown.len() as f64 + 1.0) <= REPEATS
            && turns >= TURNS * (of_errors.len() as f64 - 1.0)
            && typical >= 0.5 * usual
            && typical_of(&of_errors) >= UNEXPLAINED * typical
    };
    let mut long_enough = sides.iter().filter(|side| side.len() > LEAST_BESIDE).peekable();
    long_enough.peek().is_some() && long_enough.all(is_noisy)
}

/// Positions of readings in stretches of one value that are far longer than others of the channel, where its noise shows in every row beside
/// them, or while the model moves, and by far more than it errs elsewhere: the channel froze, or was at the end of its range. Of each stretch
/// the first reading may be right.
pub fn frozen(errors: &[f64], readings: &[f64]) -> Vec<usize> {
    let runs: Vec<(usize, usize)> = (readings.chunk_by(|a, b| a == b))
        .scan(0, |at, run| {
            let first = *at;
            *at += run.len();
            Some((first, run.len()))
        })
        .collect();
    let mut lengths: Vec<f64> = runs.iter().map(|run| run.1 as f64).collect();
    lengths.sort_by(f64::total_cmp);
    if lengths.is_empty() {
        return Vec::new();
    }
    let least = (LONGER_RUN * quantile_sorted(&lengths, 0.9)).max(LEAST_RUN);
    let differences = errors.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
    let steps = readings.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
    let step = steps.fold(f64::INFINITY, f64::min);
    // Means over readings with whole steps show fractions of them on the way, and stay at whole ones.
    let held: Vec<f64> = runs.iter().filter(|run| run.1 >= LEAST_HELD).map(|run| readings[run.0]).collect();
    let whole_steps: Vec<f64> = held.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0).collect();
    let whole_step = if whole_steps.len() >= LEAST_HELD { median(whole_steps).unwrap_or(0.0) } else { 0.0 };
    let scale = median(differences).unwrap_or(0.0) + whole_step.max(if step.is_finite() { step } else { 0.0 });
    let is_long = |run: &&(usize, usize)| run.1 as f64 >= least;
    let others = runs.iter().filter(|run| !is_long(run)).flat_map(|&(first, length)| &errors[first..first + length]);
    let usual_error = MEDIAN_TO_SD * median(others.map(|error| error.abs()).collect()).unwrap_or(f64::INFINITY);
    let moves = |&(first, length): &(usize, usize)| {
        let predicted = (first..first + length).map(|at| readings[at] - errors[at]);
        let ends = predicted.fold([f64::INFINITY, f64::NEG_INFINITY], |ends, temperature| {
            [temperature.min(ends[0]), temperature.max(ends[1])]
        });
        ends[1] - ends[0] > f64::max(MOVES * scale, BEYOND_ERRORS * usual_error)
    };
    let long: Vec<(usize, usize)> = runs.iter().filter(is_long).copied().collect();
    let mut is_in_stretch = vec![false; readings.len()];
    long.iter().for_each(|&(first, length)| is_in_stretch[first..first + length].fill(true));
    let outside =
        (1..readings.len()).filter(|&at| !is_in_stretch[at]).map(|at| (readings[at] - readings[at - 1]).abs());
    let usual_change = median(outside.collect()).unwrap_or(f64::INFINITY);
    let shows_noise = |run: &(usize, usize)| shows_noise_beside(errors, readings, *run, usual_change);
    let frozen_rows: Vec<usize> = (long.iter().filter(|run| moves(run) || shows_noise(run)))
        .flat_map(|&(first, length)| first + 1..first + length)
        .collect();
    if frozen_rows.len() as f64 > MOST_FROZEN * readings.len() as f64 { Vec::new() } else { frozen_rows }
}

/// Positions of readings of steady phases in a stretch of one value that noise of `sd` about any temperature would show by
/// chance in fewer than one of `STUCK` campaigns, while the model moves: `step` is the resolution. Of each stretch the
/// first reading may be right.
pub fn stuck(errors: &[f64], readings: &[f64], sd: f64, step: f64) -> Vec<usize> {
    // A node that is held shows a coarse channel one value whatever the stated accuracy.
    if step > FINE * sd {
        return Vec::new();
    }
    // Two readings of normal noise are the same with this probability at most.
    let alike = step / (2.0 * sqrt(core::f64::consts::PI) * sd);
    let mut stuck_rows = Vec::new();
    let mut first = 0;
    for run in readings.chunk_by(|a, b| a == b) {
        let rows = first..first + run.len();
        first += run.len();
        let by_chance = readings.len() as f64 * pow(alike, run.len() as f64 - 1.0);
        let predicted = rows.clone().map(|at| readings[at] - errors[at]);
        let [least, most] = predicted.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], temperature| {
            [temperature.min(least), temperature.max(most)]
        });
        if run.len() > 2 && by_chance * STUCK < 1.0 && most - least > MOVES * (sd + step) {
            stuck_rows.extend(rows.skip(1));
        }
    }
    stuck_rows
}
