//! Readings that are faults of the data: spikes, drop-outs and channels that froze. They are found, said and left out.
//!
//! In a transient a spike is a reading, or a few, whose error jumps away from that of the rows about it and back; a drop-out
//! jumps likewise and shows one value meanwhile. A model that is wrong errs smoothly there, or jumps and stays, or jumps where
//! an input steps. In steady phases a channel stuck that shows one value in more of them than noise allows. Otherwise no row
//! has a neighbour there: a reading is a fault where a set of effects explains all but a few readings, and these not at all.
//! What two sensors or more show together is no fault of a sensor, and stays (`together.rs`).

use crate::diagnosis::engine::{Diagnosis, FitRequest, State};
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::odds::posterior_odds::log_posterior_weights;
use crate::diagnosis::together::{Jump, LONGEST_ANSWER, are_alike, shown_by};
use crate::diagnosis::verdict::numbers::{joined, rounded};
use crate::diagnosis::{FitError, Problem, Refit};
use crate::document::code::{OUTLYING, TOGETHER};
use crate::document::counted;
use crate::document::time::unit_of_time;
use crate::inference::likelihood::HALF_LN_TAU;
use crate::math::functions::{ln, pow, sqrt};
use crate::measurement::{Doubt, InputColumn, InputTable, Measurement, Rows};
use crate::statistics::quantile::quantile_sorted;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ops::Range;

/// Digits of the time of a reading, by which its row is found.
const TIME_DIGITS: usize = 6;

/// A reading that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Position of the measurement.
    pub measurement: usize,
    /// Row.
    pub row: usize,
    /// Position of the sensor.
    pub sensor: usize,
    /// Reading minus what the others say, SI.
    pub off: f64,
}

/// An excursion that several sensors of a measurement show, and that stays in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Excursion {
    /// Position of the measurement.
    pub measurement: usize,
    /// Its first row.
    pub row: usize,
    /// Positions of the sensors.
    pub sensors: Vec<usize>,
}

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
/// Least error of a reading in a steady phase, in standard deviations of the noise and of what the others leave.
const OUTLYING_SDS: f64 = 6.0;
/// Most readings of steady phases, as a share, that are taken for faults.
const MOST_OF_STEADY: f64 = 0.04;
/// Minus the log density of a fault, in standard deviations: one reading in a thousand is one, anywhere in a range of a hundred
/// standard deviations; `ln 1e5`.
const COSTS: f64 = 11.512_925_464_970_229;
/// Sets that are fitted without their faults.
const MOST_REFITTED: usize = 4;
/// Fewest readings of a stretch of one value that is taken for frozen.
const LEAST_RUN: f64 = 8.0;
/// Fewest readings of one value that show a channel's resolution, and fewest changes between such stretches.
const LEAST_HELD: usize = 3;
/// Times that such a stretch is longer than nine of ten stretches of the channel.
const LONGER_RUN: f64 = 4.0;
/// The model moves meanwhile by this many typical changes of its error and steps of the channel.
const MOVES: f64 = 8.0;
/// Campaigns of which one has a stretch of steady phases that is taken for stuck, where the noise is as stated.
const STUCK: f64 = 1e5;
/// Largest resolution of a channel that may be stuck in steady phases, in standard deviations of its noise.
const FINE: f64 = 0.1;
/// Most readings of a sensor, as a share, that are taken for those of a frozen channel.
const MOST_FROZEN: f64 = 0.5;
/// Standard deviation of a normal variable in its median absolute deviations.
const MEDIAN_TO_SD: f64 = 1.482_602_218_505_602;
/// Share of a jump of the error that the channel itself must show.
const LEAST_OF_JUMP: f64 = 0.5;

/// The median; `None` of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| quantile_sorted(&values, 0.5))
}

/// A sensor's errors, row by row, what it showed, and how much it moves.
struct Channel<'a> {
    errors: &'a [f64],
    readings: &'a [f64],
    /// Distance of each error to the median of those about it.
    distances: Vec<f64>,
    /// Least height of a spike anywhere in it.
    of_all: f64,
}

impl<'a> Channel<'a> {
    fn new(errors: &'a [f64], readings: &'a [f64]) -> Self {
        let mut channel = Self { errors, readings, distances: Vec::new(), of_all: 0.0 };
        channel.distances = (0..errors.len()).map(|at| (errors[at] - channel.beside(at, at + 1)).abs()).collect();
        let steps = readings.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
        // A channel that shows whole steps does not stand out by one.
        let resolution = steps.fold(f64::INFINITY, f64::min);
        let of_all = MEDIAN_TO_SD * median(channel.distances.clone()).unwrap_or(0.0);
        channel.of_all = SPIKE * of_all.max(if resolution.is_finite() { 0.5 * resolution } else { 0.0 });
        channel
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
    fn spikes(&self) -> Vec<(Range<usize>, f64)> {
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
    fn answers(&self, at: usize, by: f64) -> bool {
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
fn is_near_step(steps: &[usize], row: usize) -> bool {
    let next = steps.partition_point(|&step| step + AFTER_STEP < row);
    steps.get(next).is_some_and(|&step| step <= row + BEFORE_STEP)
}

/// Positions of readings in stretches of one value that are far longer than others of the channel, while the model moves: the
/// channel froze, or was at the end of its range. Of each stretch the first reading may be right.
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
    let moves = |&(first, length): &(usize, usize)| {
        let predicted = (first..first + length).map(|at| readings[at] - errors[at]);
        let ends = predicted.fold([f64::INFINITY, f64::NEG_INFINITY], |ends, temperature| {
            [temperature.min(ends[0]), temperature.max(ends[1])]
        });
        ends[1] - ends[0] > MOVES * scale
    };
    let is_frozen = |run: &&(usize, usize)| run.1 as f64 >= least && moves(run);
    let frozen_rows: Vec<usize> =
        runs.iter().filter(is_frozen).flat_map(|&(first, length)| first + 1..first + length).collect();
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

/// Errors of a fit by measurement, row and sensor: of what it saw, and of what it did not.
fn all_errors(problem: &Problem, refit: &Refit) -> Vec<LeftOut> {
    let fitted = problem.fitted_readings();
    let fitted = fitted.iter().zip(&refit.errors).map(|(reading, error)| LeftOut {
        measurement: reading.measurement,
        row: reading.row,
        sensor: reading.sensor,
        off: *error,
    });
    let unseen = refit.held_out.iter().map(|reading| LeftOut {
        measurement: reading.measurement,
        row: reading.row,
        sensor: reading.sensor,
        off: reading.error,
    });
    let mut all: Vec<LeftOut> = fitted.chain(unseen).collect();
    all.sort_by_key(|one| (one.measurement, one.sensor, one.row));
    all
}

/// The name of a steady phase, or the time of a row.
fn row_in_words(measurement: &Measurement, row: usize) -> String {
    match &measurement.rows {
        Rows::Steady(phases) => phases[row].name.clone(),
        Rows::Transient { inputs, .. } => {
            let (length, unit) = unit_of_time(inputs.longest_s());
            format!("{} {unit}", rounded(inputs.times_s[row] / length, TIME_DIGITS))
        }
    }
}

/// What a sensor of a measurement erred by and showed.
struct Series<'a> {
    of: &'a [LeftOut],
    errors: Vec<f64>,
    readings: Vec<f64>,
}

fn is_steady(measurement: &Measurement) -> bool {
    matches!(measurement.rows, Rows::Steady(_))
}

/// Positions of the spikes of each series of a transient, and what several show.
fn spikes_of(measurement: &Measurement, series: &[&Series<'_>]) -> (Vec<Vec<usize>>, Vec<Excursion>) {
    let steps = match &measurement.rows {
        Rows::Transient { inputs, .. } => input_steps(inputs),
        Rows::Steady(_) => Vec::new(),
    };
    let channels: Vec<Channel<'_>> = series.iter().map(|own| Channel::new(&own.errors, &own.readings)).collect();
    let mut places: Vec<(usize, Vec<usize>)> = Vec::new();
    let mut jumps: Vec<Jump> = Vec::new();
    for (position, (own, channel)) in series.iter().zip(&channels).enumerate() {
        for (at, by) in channel.spikes() {
            // What jumps as an input steps may be the answer of the hardware.
            let free: Vec<usize> = at.clone().filter(|&at| !is_near_step(&steps, own.of[at].row)).collect();
            let (Some(first), Some(last)) = (free.first().copied(), free.last().copied()) else { continue };
            let others = own.readings.iter().enumerate().filter(|(place, _)| !at.contains(place));
            let [least, most] = others
                .fold([f64::INFINITY, f64::NEG_INFINITY], |ends, (_, &value)| [ends[0].min(value), ends[1].max(value)]);
            let readings: Vec<(usize, f64)> = (first..=last).map(|at| (own.of[at].row, own.readings[at])).collect();
            jumps.push(Jump {
                channel: position,
                rows: own.of[first].row..own.of[last].row + 1,
                by,
                sd: channel.of_all / SPIKE,
                is_beyond: readings.iter().all(|(_, value)| *value < least || *value > most),
                readings,
            });
            places.push((position, free));
        }
    }
    let mut spike_rows = vec![Vec::new(); series.len()];
    let mut excursions: Vec<Excursion> = Vec::new();
    let answers = |other: usize, jump: &Jump| {
        let at = series[other].of.partition_point(|one| one.row < jump.rows.start);
        channels[other].answers(at, jump.by)
    };
    let shown = shown_by(&jumps, series.len(), answers);
    for ((jump, shown), (position, places)) in jumps.iter().zip(shown).zip(places) {
        if shown.len() < 2 {
            spike_rows[position].extend(places);
            continue;
        }
        let first = jump.rows.start;
        let sensors = || shown.iter().map(|&channel| series[channel].of[0].sensor);
        let at = series[position].of[0].measurement;
        match excursions.iter_mut().find(|one| one.row.abs_diff(first) <= 1) {
            Some(known) => {
                known.row = known.row.min(first);
                known.sensors.extend(sensors());
                known.sensors.sort_unstable();
                known.sensors.dedup();
            }
            None => excursions.push(Excursion { measurement: at, row: first, sensors: sensors().collect() }),
        }
    }
    excursions.sort_by_key(|one| one.row);
    (spike_rows, excursions)
}

impl Problem {
    /// Spikes, drop-outs and frozen stretches of the transients, and channels that stuck in steady phases, at a fit; and what looks
    /// like spikes, but is shown by several sensors.
    pub(crate) fn faults_of_channels(&self, refit: &Refit) -> (Vec<LeftOut>, Vec<Excursion>) {
        let all = all_errors(self, refit);
        let readings_of = |series_errors: &[LeftOut]| -> Vec<f64> {
            let measurement = &self.measurements[series_errors[0].measurement];
            series_errors.iter().filter_map(|one| measurement.reading(one.row, one.sensor)).collect()
        };
        // The finest difference that any channel of a measurement shows: a stuck one shows none.
        let step_of = |measurement: usize| {
            let of_measurement = all.chunk_by(|a, b| (a.measurement, a.sensor) == (b.measurement, b.sensor));
            let channels = of_measurement.filter(|channel| channel[0].measurement == measurement).map(readings_of);
            let differences = channels
                .flat_map(|readings| readings.windows(2).map(|two| (two[1] - two[0]).abs()).collect::<Vec<_>>());
            differences.filter(|difference| *difference > 0.0).fold(f64::INFINITY, f64::min)
        };
        let (mut faults, mut excursions) = (Vec::new(), Vec::new());
        for of_measurement in all.chunk_by(|a, b| a.measurement == b.measurement) {
            let measurement = &self.measurements[of_measurement[0].measurement];
            let series: Vec<Series<'_>> = (of_measurement.chunk_by(|a, b| a.sensor == b.sensor))
                .map(|own| Series {
                    of: own,
                    errors: own.iter().map(|one| one.off).collect(),
                    readings: readings_of(own),
                })
                .collect();
            if is_steady(measurement) {
                for own in &series {
                    let sd = measurement.sensors[own.of[0].sensor].total_sd();
                    let stuck = stuck(&own.errors, &own.readings, sd, step_of(own.of[0].measurement));
                    faults.extend(stuck.into_iter().map(|at| own.of[at]));
                }
                continue;
            }
            let unit = |own: &Series<'_>| &self.model.quantities[measurement.sensors[own.of[0].sensor].quantity].unit;
            let mut spike_rows = vec![Vec::new(); series.len()];
            // Only what is measured in one unit can be compared.
            let units: BTreeSet<&String> = series.iter().map(unit).collect();
            for of_unit in units {
                let alike: Vec<usize> = (0..series.len()).filter(|&place| unit(&series[place]) == of_unit).collect();
                let own: Vec<&Series<'_>> = alike.iter().map(|&place| &series[place]).collect();
                let (spikes, shared) = spikes_of(measurement, &own);
                excursions.extend(shared);
                for (place, spikes) in alike.into_iter().zip(spikes) {
                    spike_rows[place] = spikes;
                }
            }
            for (own, mut faulty) in series.iter().zip(spike_rows) {
                faulty.extend(frozen(&own.errors, &own.readings));
                faulty.sort_unstable();
                faulty.dedup();
                faults.extend(faulty.into_iter().map(|at| own.of[at]));
            }
        }
        (faults, excursions)
    }

    /// Readings of steady phases that a fit does not explain while it explains all others; none where they would be too many,
    /// with so many that are left out already.
    fn outlying(&self, refit: &Refit, left_out: usize) -> Vec<LeftOut> {
        let mut all = all_errors(self, refit);
        all.retain(|one| is_steady(&self.measurements[one.measurement]));
        let in_sds = |one: &LeftOut| {
            let sd = self.measurements[one.measurement].sensors[one.sensor].total_sd();
            (one.off / sd.max(f64::MIN_POSITIVE)).abs()
        };
        let scale = MEDIAN_TO_SD * median(all.iter().map(in_sds).collect()).unwrap_or(0.0);
        let mut far: Vec<LeftOut> =
            all.iter().filter(|one| in_sds(one) > OUTLYING_SDS * scale.max(1.0)).copied().collect();
        let shown = |one: &LeftOut| self.measurements[one.measurement].reading(one.row, one.sensor);
        // What two sensors show together in a phase is the article's, unless they show one code.
        let is_with = |one: &LeftOut, other: &LeftOut| {
            (one.measurement, one.row) == (other.measurement, other.row)
                && one.sensor != other.sensor
                && one.off * other.off > 0.0
                && shown(one) != shown(other)
        };
        let candidates = far.clone();
        far.retain(|one| !candidates.iter().any(|other| is_with(one, other)));
        let most = (MOST_OF_STEADY * (all.len() + left_out) as f64).max(1.0);
        if (far.len() + left_out) as f64 > most { Vec::new() } else { far }
    }
}

impl Diagnosis {
    /// The diagnosis without readings.
    pub(crate) fn without(&self, left_out: &[LeftOut]) -> Self {
        let mut remaining = self.clone();
        for one in left_out {
            remaining.forget(one.measurement, one.row, one.sensor);
        }
        remaining
    }

    /// The diagnosis begun anew without readings of steady phases that the best set does not explain, which explains the others;
    /// again and again, since one fault hides another. Sets are weighed with such readings as faults, the most promising fitted
    /// without them. `None` where there are none.
    pub(crate) fn leave_out(&self, state: &State) -> Result<Option<State>, FitError> {
        if !self.problem().measurements.iter().any(is_steady) || !self.finds(&state.screening) {
            return Ok(None);
        }
        let problem = self.with_noise(&state.noise, &state.most_steps);
        let logs = log_posterior_weights(&problem, &state.refits);
        let cost = |one: &LeftOut| COSTS + ln(problem.measurements[one.measurement].sensors[one.sensor].total_sd());
        let is_seen = |one: &&LeftOut| !problem.measurements[one.measurement].held_out(one.row);
        let mut with_faults: Vec<(f64, Vec<LeftOut>, usize)> = (0..state.refits.len())
            .filter_map(|place| {
                let faults = problem.outlying(&state.refits[place], state.left_out.len());
                let square = |one: &LeftOut| {
                    let ratio = one.off / problem.measurements[one.measurement].sensors[one.sensor].total_sd();
                    0.5 * ratio * ratio + HALF_LN_TAU - COSTS
                };
                let log = logs[place] + faults.iter().filter(is_seen).map(square).sum::<f64>();
                (!faults.is_empty()).then_some((log, faults, place))
            })
            .collect();
        with_faults.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let without_faults = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (_, faults, place) in with_faults.into_iter().take(MOST_REFITTED) {
            let effects = &state.refits[place].effects;
            let without_faults_diagnosis = self.without(&faults);
            let begin = Begin {
                starts: vec![state.refits[place].by_name()],
                scale: 1.0,
                widths: state.refits[place].widths(),
                is_near: true,
                ..Begin::default()
            };
            let Ok(refit) =
                without_faults_diagnosis.with_noise(&state.noise, &state.most_steps).refit(effects, &begin, self.key())
            else {
                continue;
            };
            let log = log_posterior_weights(&problem, std::slice::from_ref(&refit))[0];
            if log - faults.iter().filter(is_seen).map(cost).sum::<f64>() <= without_faults {
                continue;
            }
            let mut next = without_faults_diagnosis.screen()?;
            next.left_out = [state.left_out.as_slice(), &faults, &next.left_out].concat();
            next.left_out.sort_by_key(|one| (one.measurement, one.sensor, one.row));
            next.warnings.clone_from(&state.warnings);
            if !effects.is_empty() && !next.is_known(effects) {
                next.pending.push(FitRequest { effects: effects.clone(), starts: vec![refit.by_name()], from: 0 });
            }
            return Ok(Some(next));
        }
        Ok(None)
    }

    /// What is said of excursions that several sensors show, a measurement a sentence.
    pub(crate) fn doubts_of_excursions(&self, excursions: &[Excursion]) -> Vec<Doubt> {
        let one = |of_measurement: &[Excursion]| {
            let measurement = &self.problem().measurements[of_measurement[0].measurement];
            let mut sensors: Vec<usize> = of_measurement.iter().flat_map(|one| one.sensors.clone()).collect();
            sensors.sort_unstable();
            sensors.dedup();
            let names: Vec<String> = sensors.iter().map(|&sensor| measurement.sensors[sensor].name.clone()).collect();
            let message = format!(
                "Readings of {} in {} jump together and come back (at {}{}): no fault of a sensor but something that the article \
                 did, and they are kept",
                joined(&names),
                measurement.name,
                of_measurement
                    .iter()
                    .take(3)
                    .map(|one| row_in_words(measurement, one.row))
                    .collect::<Vec<_>>()
                    .join(", "),
                if of_measurement.len() > 3 { ", ..." } else { "" },
            );
            Doubt {
                code: TOGETHER.name.to_owned(),
                message,
                repair: Some("find what happened then; empty the cells only if it was the logger".to_owned()),
            }
        };
        excursions.chunk_by(|a, b| a.measurement == b.measurement).map(one).collect()
    }

    /// What is said of readings that were left out, a sensor a sentence.
    pub(crate) fn doubts_of(&self, left_out: &[LeftOut]) -> Vec<Doubt> {
        let problem = self.problem();
        let series = left_out.chunk_by(|a, b| (a.measurement, a.sensor) == (b.measurement, b.sensor));
        let one = |of_sensor: &[LeftOut]| {
            let measurement = &problem.measurements[of_sensor[0].measurement];
            let sensor = &measurement.sensors[of_sensor[0].sensor];
            let most = of_sensor.iter().map(|one| one.off).fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
            let [stand, are, most_word] =
                if of_sensor.len() == 1 { ["stands", "is", "by"] } else { ["stand", "are", "by up to"] };
            let message = format!(
                "{} of {} in {} ({}{}) {stand} out from what all others say, {most_word} {most:.2} {}, and {are} left out",
                counted(of_sensor.len(), "reading"),
                sensor.name,
                measurement.name,
                of_sensor.iter().take(3).map(|one| row_in_words(measurement, one.row)).collect::<Vec<_>>().join(", "),
                if of_sensor.len() > 3 { ", ..." } else { "" },
                problem.model.quantities[sensor.quantity].unit,
            );
            Doubt {
                code: OUTLYING.name.to_owned(),
                message,
                repair: Some("empty their cells, or find what made them".to_owned()),
            }
        };
        series.map(one).collect()
    }
}
