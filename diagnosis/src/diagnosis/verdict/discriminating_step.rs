//! The step that parts rivals which differ in what stores heat alone: of one input, from a steady state, between values that the
//! data have or, where none of these is worth a test, between the ends of its range; watched for some time constants of the
//! slowest sensor. How well it parts them is found as for steady phases.

use crate::diagnosis::Problem;
use crate::diagnosis::output::DiscriminatingStep;
use crate::diagnosis::verdict::discriminating_experiment::{
    distinguishing_probability, is_within_limits, is_worth_a_test, settable, setting,
};
use crate::diagnosis::verdict::rival::{Predicted, Rival, square};
use crate::diagnosis::verdict::tested::{self, Tested};
use crate::math::functions::pow;
use crate::math::sort::sort_by;
use crate::measurement::prediction::{Prediction, Predictor};
use crate::measurement::{Initial, InputColumn, InputTable, Measurement, Rows, Uncertain};
use crate::thermal::{Clock, Model};
use crate::watch;

/// Inputs whose steps are tried: those that moved over the largest shares of their ranges.
const MOST_INPUTS: usize = 6;
/// Time constants of the slowest sensor for which a step is watched: what is left then is a twentieth.
const TIME_CONSTANTS: f64 = 3.0;
/// Readings of each sensor: as often as in the record, but so many at most and at least.
const MOST_ROWS: usize = 400;
const LEAST_ROWS: usize = 24;
/// Share of the time that the hardware bears for which a step is watched: two digits of it may be rounded upwards.
const WITHIN: f64 = 0.95;
/// Readings at the record's own pace that such a step has at least.
const LEAST_OF_RECORD: f64 = 2.0;
/// Instants at which the approach to the new state is looked at, in geometric progression.
const INSTANTS: usize = 200;
/// The first of them after the step, as a share of the last.
const FIRST: f64 = 1e-4;
/// Share of the largest movement from which a sensor follows the step.
const FOLLOWS: f64 = 0.1;

/// A step of one input.
#[derive(Clone, Copy, Debug)]
struct Stepped {
    input: usize,
    from: f64,
    to: f64,
    /// Whether it goes beyond the values that the data have.
    is_wide: bool,
}

/// A step as it was judged.
struct Judged {
    step: Stepped,
    square: f64,
    within_limits: bool,
    near_tested: bool,
    duration_s: f64,
    ends_early: bool,
    /// The slowest sensor and its time constant, s.
    slowest: (usize, f64),
}

/// The step that parts all rivals from the first best; nothing where no transient was measured, or no input can be set.
pub(super) fn best(problem: &Problem, rivals: &[&Rival<'_>]) -> Option<DiscriminatingStep> {
    let is_transient = |own: &&Measurement| matches!(own.rows, Rows::Transient { .. }) && !own.is_empty();
    let template = problem.measurements.iter().find(is_transient)?;
    let longest_s = problem.measurements.iter().filter(is_transient).map(span_s).fold(0.0, f64::max);
    let best_of = |wide: bool| {
        let judged =
            steps(problem, wide).into_iter().filter_map(|step| judge(problem, rivals, template, step, longest_s));
        judged.reduce(better)
    };
    let best = match best_of(false) {
        Some(known) if known.is_enough() => known,
        known => known.into_iter().chain(best_of(true)).reduce(better)?,
    };
    let of = |value: f64| setting(&problem.model, best.step.input, value);
    Some(DiscriminatingStep {
        input: problem.model.inputs[best.step.input].name.clone(),
        from: of(best.step.from),
        to: of(best.step.to),
        like: template.name.clone(),
        duration_s: best.duration_s,
        slowest: template.sensors[best.slowest.0].name.clone(),
        time_constant_s: best.slowest.1,
        probability: distinguishing_probability(best.square),
        limits_ok: best.within_limits,
        near_tested: best.near_tested,
        was_set: !best.step.is_wide,
        ends_early: best.ends_early,
    })
}

impl Judged {
    /// Whether the hardware surely bears it.
    fn is_borne(&self) -> bool {
        self.within_limits && self.near_tested
    }

    /// Whether it is that, and worth a test.
    fn is_enough(&self) -> bool {
        self.is_borne() && is_worth_a_test(distinguishing_probability(self.square))
    }
}

/// The better one of two: what the hardware bears goes first.
fn better(a: Judged, b: Judged) -> Judged {
    let rank = |one: &Judged| (one.within_limits, one.near_tested);
    if rank(&b) > rank(&a) || rank(&b) == rank(&a) && b.square > a.square { b } else { a }
}

/// Steps up and down, between the values that the data have within the input's range, or `wide`: over its whole range. What moved
/// most goes first.
fn steps(problem: &Problem, wide: bool) -> Vec<Stepped> {
    let mut inputs: Vec<(f64, usize, [f64; 2])> = Vec::new();
    for (index, [lower, upper]) in settable(&problem.model) {
        let clipped =
            tested::input(problem, index).map(|[low, high]| [low.max(lower).min(upper), high.min(upper).max(lower)]);
        let moved = clipped.filter(|[low, high]| low < high);
        let share = moved.map_or(0.0, |[low, high]| (high - low) / (upper - lower));
        let between = if wide { Some([lower, upper]) } else { moved };
        inputs.extend(between.map(|between| (share, index, between)));
    }
    sort_by(&mut inputs, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    inputs.truncate(MOST_INPUTS);
    let both = move |(_, input, [low, high]): (f64, usize, [f64; 2])| {
        let one = |from: f64, to: f64| Stepped { input, from, to, is_wide: wide };
        [one(low, high), one(high, low)]
    };
    inputs.into_iter().flat_map(both).collect()
}

/// The step, watched for three time constants or, where the hardware may not bear that and less is worth a test, as long as it
/// surely does by all rivals.
fn judge(
    problem: &Problem,
    rivals: &[&Rival<'_>],
    template: &Measurement,
    step: Stepped,
    longest_s: f64,
) -> Option<Judged> {
    watch::check();
    let first = *rivals.first()?;
    let looked_at = geometric(longest_s);
    let parameters: Vec<Vec<f64>> = rivals
        .iter()
        .map(|rival| rival.full_parameters(&rival.at(&stepped(problem, rival, template, step, &[0.0, 1.0])?)?))
        .collect::<Option<_>>()?;
    // Of each rival what it predicts of the step.
    let predictions = |instants: &[f64]| -> Option<Vec<(Measurement, Prediction)>> {
        let of = |(rival, parameters): (&&Rival<'_>, &Vec<f64>)| {
            let predictor = Predictor::new(&rival.problem.model, &[]).ok()?;
            let mut measurement = stepped(problem, rival, template, step, instants)?;
            // Time constants and limits are those of what happens, whenever a clock shows it.
            measurement.sensors.iter_mut().for_each(|sensor| sensor.behind_s.clear());
            let prediction = predictor.predict(&mut predictor.workspace(), &measurement, parameters);
            Some((measurement, prediction))
        };
        rivals.iter().zip(&parameters).map(of).collect()
    };
    let coarse = predictions(&looked_at)?;
    let (measured, predicted) = coarse.first()?;
    let slowest = slowest(&first.problem.model, measured, predicted, &looked_at)?;
    let borne = |own: &[(Measurement, Prediction)]| -> Vec<Borne> {
        rivals.iter().zip(own).map(|(rival, own)| borne(problem, rival, template, &own.1)).fold(Vec::new(), both)
    };
    let watched = |duration_s: f64, ends_early: bool| {
        let rows = (template.len() as f64 * duration_s / span_s(template)) as usize;
        let rows = rows.clamp(LEAST_ROWS, MOST_ROWS);
        let instants: Vec<f64> = (0..rows).map(|row| duration_s * row as f64 / (rows - 1) as f64).collect();
        let all: Vec<Predicted> = rivals
            .iter()
            .map(|rival| rival.at(&stepped(problem, rival, template, step, &instants)?))
            .collect::<Option<_>>()?;
        let all_rows: Vec<usize> = (0..all[0].residuals.len()).collect();
        let mut least = f64::INFINITY;
        for (rival, own) in rivals.iter().zip(&all).skip(1) {
            watch::check();
            least = least.min(square(&all[0], rival, own, &all_rows));
        }
        let rows = borne(&predictions(&instants)?);
        let within_limits = rows.iter().all(|row| row.within_limits);
        let near_tested = rows.iter().all(|row| row.near_tested);
        let judged = Judged { step, square: least, within_limits, near_tested, duration_s, ends_early, slowest };
        least.is_finite().then_some(judged)
    };
    let whole = watched((TIME_CONSTANTS * slowest.1).min(longest_s), false)?;
    if whole.is_borne() {
        return Some(whole);
    }
    // Row 0 stands before the step.
    let until = borne(&coarse).iter().take_while(|row| row.within_limits && row.near_tested).count();
    let borne_s = WITHIN * until.checked_sub(2).and_then(|last| looked_at.get(last)).copied().unwrap_or(0.0);
    let is_seen = borne_s * template.len() as f64 >= LEAST_OF_RECORD * span_s(template);
    let shorter = (is_seen && borne_s < whole.duration_s).then(|| watched(borne_s, true)).flatten();
    Some(shorter.filter(Judged::is_enough).unwrap_or(whole))
}

/// What of a row the hardware surely bears.
struct Borne {
    within_limits: bool,
    near_tested: bool,
}

/// Rows that the hardware bears by two predictions; by one where there is no other.
fn both(known: Vec<Borne>, other: Vec<Borne>) -> Vec<Borne> {
    if known.is_empty() {
        return other;
    }
    let of = |(a, b): (&Borne, &Borne)| Borne {
        within_limits: a.within_limits && b.within_limits,
        near_tested: a.near_tested && b.near_tested,
    };
    known.iter().zip(&other).map(of).collect()
}

/// Of each row of a prediction by a rival whether the hardware surely bears it.
fn borne(problem: &Problem, rival: &Rival<'_>, template: &Measurement, prediction: &Prediction) -> Vec<Borne> {
    let nodes = problem.model.nodes.len();
    let tested = Tested::of(problem);
    let is_near =
        |(sensor, value): (usize, &f64)| tested.is_near(&problem.model, template.sensors[sensor].quantity, *value);
    let temperatures = prediction.temperatures.chunks_exact(rival.problem.model.nodes.len());
    let readings = prediction.readings.chunks_exact(template.sensors.len());
    temperatures
        .zip(readings)
        .map(|(temperatures, readings)| Borne {
            within_limits: is_within_limits(&problem.model, &temperatures[..nodes.min(temperatures.len())]),
            near_tested: readings.iter().enumerate().all(is_near),
        })
        .collect()
}

/// From the first row of a transient to its last, s.
fn span_s(measurement: &Measurement) -> f64 {
    match &measurement.rows {
        Rows::Transient { inputs, .. } => inputs.times_s.last().zip(inputs.times_s.first()).map_or(0.0, |(b, a)| b - a),
        Rows::Steady(_) => 0.0,
    }
}

/// Instants after the step, the first at it.
fn geometric(last_s: f64) -> Vec<f64> {
    let ratio = |place: usize| pow(FIRST, 1.0 - place as f64 / (INSTANTS - 1) as f64);
    std::iter::once(0.0).chain((0..INSTANTS).map(|place| last_s * ratio(place))).collect()
}

/// The transient of a step: in balance before it, read at instants after it. The step lies a little after the first row, in which the
/// inputs are those of the template's first row but for the one that steps; what the rival changes of sensors is theirs.
fn stepped(
    problem: &Problem,
    rival: &Rival<'_>,
    template: &Measurement,
    step: Stepped,
    instants: &[f64],
) -> Option<Measurement> {
    let changed = rival.problem.measurements.iter().find(|own| own.name == template.name)?;
    let Rows::Transient { inputs, .. } = &template.rows else { return None };
    let mut base: Vec<f64> = (0..problem.model.inputs.len()).map(|index| inputs.in_row(0, index)).collect();
    for clock in Clock::ALL.into_iter().filter_map(|clock| problem.model.clocks.get(clock)) {
        // A new test comes after all others.
        base[clock] = problem.model.inputs[clock].nominal;
    }
    let before_s = FIRST * (instants.last()? - instants.first()?);
    let times_s: Vec<f64> = std::iter::once(0.0).chain(instants.iter().map(|time| before_s + time)).collect();
    let rows = times_s.len();
    let values = (0..rows).map(|row| if row == 0 { step.from } else { step.to }).collect();
    let columns = vec![InputColumn { input: step.input, values, hold: true }];
    let is_read = |sensor: usize| (0..template.len()).any(|row| template.reading(row, sensor).is_some());
    let read: Vec<bool> = (0..template.sensors.len()).map(is_read).collect();
    let readings = (0..rows).flat_map(|row| read.iter().map(move |&is_read| (is_read && row > 0).then_some(0.0)));
    let mut sensors = changed.sensors.clone();
    for sensor in &mut sensors {
        // Clocks that are known to be off do so for all rivals.
        sensor.behind_s.retain(|behind| !matches!(behind, Uncertain::Known(_)));
    }
    Some(Measurement {
        rows: Rows::Transient {
            inputs: InputTable { times_s, columns, base },
            initial: Initial::Steady,
            held_out: vec![false; rows],
            ignored: vec![None; rows],
        },
        sensors,
        readings: readings.collect(),
        follows_gap: false,
        ..template.clone()
    })
}

/// The sensor of those that follow the step which is last to have all but 1/e of its change behind it, and when, s. The model is that
/// of the rival, whose effects may change what a sensor reads.
fn slowest(
    model: &Model,
    measurement: &Measurement,
    prediction: &Prediction,
    instants: &[f64],
) -> Option<(usize, f64)> {
    let width = measurement.sensors.len();
    let is_temperature = |sensor: usize| model.quantities[measurement.sensors[sensor].quantity].is_temperature;
    let is_read = |sensor: usize| measurement.readings[width..2 * width][sensor].is_some();
    let at = |row: usize, sensor: usize| prediction.readings[row * width + sensor];
    let last = measurement.len() - 1;
    let sensors = || (0..width).filter(|&sensor| is_read(sensor) && is_temperature(sensor));
    let moved = |sensor: usize| (at(last, sensor) - at(0, sensor)).abs();
    let most = sensors().map(moved).filter(|moved| moved.is_finite()).fold(0.0, f64::max);
    let follows = sensors().filter(|&sensor| most > 0.0 && moved(sensor) >= FOLLOWS * most);
    let constant = |sensor: usize| {
        let left = |row: &usize| (at(*row, sensor) - at(last, sensor)).abs() > moved(sensor) / core::f64::consts::E;
        // Row 0 stands before the step.
        let late = (1..=last).rev().find(left)?;
        Some((sensor, instants[late.min(instants.len() - 1)]))
    };
    follows.filter_map(constant).reduce(|a, b| if b.1 > a.1 { b } else { a }).filter(|(_, time)| *time > 0.0)
}
