//! Readings that are faults of the data: spikes, drop-outs and channels that froze. They are found, said and left out.
//!
//! In a transient a spike is a reading, or a few, whose error jumps away from that of the rows about it and back; a drop-out
//! jumps likewise and shows one value meanwhile. A model that is wrong errs smoothly there, or jumps and stays, or jumps where
//! an input steps. In steady phases a channel stuck that shows one value in more of them than noise allows. Otherwise no row
//! has a neighbour there: a reading is a fault where a set of effects explains all but a few readings, and these not at all.
//! What one channel shows is in `channel.rs`. What two sensors or more show together is no fault of a sensor, and stays (`together.rs`).

use crate::diagnosis::channel::{Channel, MEDIAN_TO_SD, frozen, input_steps, is_near_step, median, stuck};
use crate::diagnosis::engine::{Diagnosis, FitRequest, State};
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::odds::posterior_odds::log_posterior_weights;
use crate::diagnosis::together::{Jump, shown_by};
use crate::diagnosis::verdict::numbers::{joined, rounded};
use crate::diagnosis::{FitError, Problem, Refit};
use crate::document::code::{OUTLYING, TOGETHER};
use crate::document::counted;
use crate::document::time::unit_of_time;
use crate::inference::likelihood::HALF_LN_TAU;
use crate::math::functions::ln;
use crate::math::sort::{sort_by, sort_by_key};
use crate::measurement::{Doubt, Measurement, Rows};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Rows that are named of one sensor.
const NAMED: usize = 3;
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
    /// Whether it is in a stretch of one value, in which its channel froze.
    pub frozen: bool,
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

/// Least error of a reading in a steady phase, in standard deviations of the noise and of what the others leave.
const OUTLYING_SDS: f64 = 6.0;
/// Most readings of steady phases, as a share, that are taken for faults.
const MOST_OF_STEADY: f64 = 0.04;
/// Minus the log density of a fault, in standard deviations: one reading in a thousand is one, anywhere in a range of a hundred
/// standard deviations; `ln 1e5`.
const COSTS: f64 = 11.512_925_464_970_229;
/// Sets that are fitted without their faults.
const MOST_REFITTED: usize = 4;

/// Errors of a fit by measurement, row and sensor: of what it saw, and of what it did not.
fn all_errors(problem: &Problem, refit: &Refit) -> Vec<LeftOut> {
    let fitted = problem.fitted_readings();
    let fitted = fitted.iter().zip(&refit.errors).map(|(reading, error)| LeftOut {
        measurement: reading.measurement,
        row: reading.row,
        sensor: reading.sensor,
        off: *error,
        frozen: false,
    });
    let unseen = refit.held_out.iter().map(|reading| LeftOut {
        measurement: reading.measurement,
        row: reading.row,
        sensor: reading.sensor,
        off: reading.error,
        frozen: false,
    });
    let mut all: Vec<LeftOut> = fitted.chain(unseen).collect();
    sort_by_key(&mut all, |one| (one.measurement, one.sensor, one.row));
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

/// Where readings of a sensor are, in the order of rows: from when to when in a stretch without a gap, else the first few.
fn rows_in_words(measurement: &Measurement, readings: &[LeftOut]) -> String {
    let row = |one: &LeftOut| row_in_words(measurement, one.row);
    match readings {
        [first, .., last] if readings.len() > NAMED && last.row - first.row + 1 == readings.len() => {
            format!("{} to {}", row(first), row(last))
        }
        _ => {
            let named = readings.iter().take(NAMED).map(row).collect::<Vec<_>>().join(", ");
            if readings.len() > NAMED { format!("{named}, ...") } else { named }
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
                sd: channel.sd(),
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
    sort_by_key(&mut excursions, |one| one.row);
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
                    faults.extend(stuck.into_iter().map(|at| LeftOut { frozen: true, ..own.of[at] }));
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
                let frozen: BTreeSet<usize> = frozen(&own.errors, &own.readings).into_iter().collect();
                faulty.extend(&frozen);
                faulty.sort_unstable();
                faulty.dedup();
                faults.extend(faulty.into_iter().map(|at| LeftOut { frozen: frozen.contains(&at), ..own.of[at] }));
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
        if !left_out.is_empty() {
            remaining.work_where_read();
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
        sort_by(&mut with_faults, |a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
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
            sort_by_key(&mut next.left_out, |one| (one.measurement, one.sensor, one.row));
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
                    .take(NAMED)
                    .map(|one| row_in_words(measurement, one.row))
                    .collect::<Vec<_>>()
                    .join(", "),
                if of_measurement.len() > NAMED { ", ..." } else { "" },
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
        let of = |one: &LeftOut| (one.measurement, one.sensor, one.frozen);
        let series = left_out.chunk_by(|a, b| of(a) == of(b));
        let one = |of_sensor: &[LeftOut]| {
            let measurement = &problem.measurements[of_sensor[0].measurement];
            let sensor = &measurement.sensors[of_sensor[0].sensor];
            let most = of_sensor.iter().map(|one| one.off).fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
            let [stand, repeat, they, are, most_word] = match of_sensor.len() {
                1 => ["stands", "repeats", "it", "is", "by"],
                _ => ["stand", "repeat", "they", "are", "by up to"],
            };
            let unit = &problem.model.quantities[sensor.quantity].unit;
            let why = match of_sensor[0].frozen {
                true => {
                    format!(
                        "{repeat} the value before: the channel froze, or its logger repeated it; {they} {are} left out"
                    )
                }
                false => {
                    format!("{stand} out from what all others say, {most_word} {most:.2} {unit}, and {are} left out")
                }
            };
            let message = format!(
                "{} of {} in {} ({}) {why}",
                counted(of_sensor.len(), "reading"),
                sensor.name,
                measurement.name,
                rows_in_words(measurement, of_sensor),
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
