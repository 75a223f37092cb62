//! The experiment that parts rivals: a steady phase, within the stated ranges of the inputs that can be set, in which the
//! rivals' predictions lie furthest apart once each has been fitted to the old data and the new. Rivals that differ in what
//! stores heat alone are parted by no such phase, but by a step: see `discriminating_step`.
//!
//! With the whitened difference `m` of two rivals' predictions, `F` the derivatives of the second's and `C` the covariance
//! of its parameters after the old data: `delta^2 = m' (I + F C F')^-1 m`, and the better one is recognised with probability
//! `Phi(delta / 2)` (Box & Hill 1967, for two hypotheses of equal probability).

use std::collections::BTreeMap;

use crate::diagnosis::output::{DiscriminatingExperiment, OneThing, OnlyInTransients, Setting};
use crate::diagnosis::verdict::discriminating_step;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::rival::{Predicted, Rival, square};
use crate::diagnosis::verdict::tested::Tested;
use crate::diagnosis::{Problem, Refit};
use crate::math::special::normal_cdf;
use crate::measurement::prediction::Predictor;
use crate::measurement::{Measurement, Phase, Rows};
use crate::random::{PointKind, Points, StreamKey};
use crate::thermal::Model;
use crate::watch;

/// Conditions that are tried at first, beside the corners.
const CONDITIONS: usize = 256;
/// Conditions that are tried round the best.
const NEARBY: usize = 64;
/// Most inputs whose corners are all tried.
const MOST_CORNERS: usize = 7;
/// A phase in which a sensor would read so much more than any did, K, is not proposed: where a conductance is extrapolated to
/// nothing, the model has no meaning.
const MEANINGLESS_K: f64 = 1000.0;
/// Most rivals that are considered.
const MOST_RIVALS: usize = 5;

/// Probability of telling two hypotheses apart below which an experiment is little better than a coin.
const USEFUL: f64 = 0.6;
/// Probability of telling two hypotheses apart from which an experiment is worth a test by itself: the right one then stands at
/// four to one on average, a wrong answer in five tests.
const WORTH_A_TEST: f64 = 0.8;

/// What would part the selected set and its rivals.
#[derive(Default)]
pub(crate) struct Discrimination {
    /// The experiment that parts them, as far as one does.
    pub experiment: Option<DiscriminatingExperiment>,
    /// Those that none parts.
    pub one_thing: Option<OneThing>,
    /// Those that none can part, since they differ in what stores heat alone.
    pub only_in_transients: Option<OnlyInTransients>,
}

/// The probability with which two hypotheses of so large a squared distance are told apart.
pub fn distinguishing_probability(square: f64) -> f64 {
    normal_cdf(0.5 * square.max(0.0).sqrt())
}

/// Whether an experiment with this probability of telling hypotheses apart is worth its cost.
pub fn is_useful(probability: f64) -> bool {
    probability >= USEFUL
}

/// Whether an experiment with this probability of telling hypotheses apart is worth a test by itself.
pub fn is_worth_a_test(probability: f64) -> bool {
    probability >= WORTH_A_TEST
}

/// The experiment that parts the rivals of the selected set, and those rivals that no phase within the limits parts from it.
/// Nothing where there is nothing to set, or no sensor to see it.
pub(crate) fn experiment(findings: &Findings<'_>) -> Discrimination {
    parted(findings).unwrap_or_default()
}

fn parted(findings: &Findings<'_>) -> Option<Discrimination> {
    let problem = findings.problem;
    let fits: Vec<&Refit> =
        findings.rivals.iter().take(MOST_RIVALS).map(|&place| &findings.state.refits[place]).collect();
    if fits.len() < 2 {
        return None;
    }
    let all: Vec<Rival> = fits.iter().map(|fit| Rival::new(problem, fit)).collect::<Option<_>>()?;
    let (first, others) = all.split_first()?;
    let (mut of_storage, mut of_steady) = (vec![first], vec![first]);
    for rival in others {
        let list = if differ_in_storage(problem, first.fit, rival.fit) { &mut of_storage } else { &mut of_steady };
        list.push(rival);
    }
    let in_steady = (of_steady.len() > 1).then(|| in_steady_phases(findings, &of_steady)).flatten();
    let in_steady = in_steady.unwrap_or_default();
    let only_in_transients = (of_storage.len() > 1).then(|| OnlyInTransients {
        between: of_storage.iter().map(|rival| named(findings, rival.fit)).collect(),
        step: discriminating_step::best(problem, &of_storage),
    });
    Some(Discrimination { only_in_transients, ..in_steady })
}

/// The ids of a set.
fn named(findings: &Findings<'_>, fit: &Refit) -> String {
    let ids: Vec<&str> = fit.effects.iter().map(|&effect| findings.id(effect)).collect();
    ids.join(" + ")
}

/// Whether two sets differ in what stores heat alone, so that no steady phase can part them: what their shared unknowns were
/// fitted to is all that they predict apart there.
fn differ_in_storage(problem: &Problem, a: &Refit, b: &Refit) -> bool {
    let stores = |&effect: &usize| {
        let candidate = &problem.candidates[effect];
        problem.catalogue.get(&candidate.effect).is_some_and(|own| own.only_stores(candidate.where_kind))
    };
    let only_in = |a: &Refit, b: &Refit| a.effects.iter().filter(|own| !b.effects.contains(own)).all(stores);
    only_in(a, b) && only_in(b, a)
}

/// Inputs that can be set, with their ranges.
pub(super) fn settable(model: &Model) -> Vec<(usize, [f64; 2])> {
    (model.inputs.iter().enumerate())
        .filter_map(|(index, input)| Some((index, input.range.filter(|r| input.settable && r[0] < r[1])?)))
        .collect()
}

/// A value of an input as a result states it.
pub(super) fn setting(model: &Model, index: usize, value: f64) -> Setting {
    let unit = crate::expression::Unit::parse(&model.inputs[index].unit);
    Setting { value, unit: unit.map(|unit| unit.dimension.to_string()).unwrap_or_default() }
}

/// The steady phase that parts rivals from the first, and those that none parts.
fn in_steady_phases(findings: &Findings<'_>, rivals: &[&Rival<'_>]) -> Option<Discrimination> {
    let problem = findings.problem;
    let settable = settable(&problem.model);
    if settable.is_empty() {
        return None;
    }
    let template = template(findings)?;
    let nominal: Vec<f64> = problem.model.inputs.iter().map(|input| input.nominal).collect();
    let judge = |conditions: &[Vec<f64>]| judge(problem, rivals, &template, conditions);
    let first = judge(&spread(&settable, &nominal))?;
    let old = old_conditions(problem);
    let repeated = if old.is_empty() { Vec::new() } else { judge(&old)? };
    let of = |rival: usize| named(findings, rivals[rival].fit);
    // Of each rival by itself: whether any phase parts it from the selected set.
    let probability = |list: &[Judged], rival: usize| {
        greatest(list, &[rival]).map_or(0.5, |best| distinguishing_probability(best.square(&[rival])))
    };
    let mut alike = Vec::new();
    let mut others = Vec::new();
    for rival in 0..rivals.len() - 1 {
        let (best, again) = (probability(&first, rival), probability(&repeated, rival));
        if is_useful(best) {
            others.push(rival);
        } else {
            alike.push((rival, best, again));
        }
    }
    let one_thing = (!alike.is_empty()).then(|| OneThing {
        sets: std::iter::once(of(0)).chain(alike.iter().map(|&(rival, _, _)| of(rival + 1))).collect(),
        probability: alike.iter().map(|own| own.1).fold(0.5, f64::max),
        repeat_probability: alike.iter().map(|own| own.2).fold(0.5, f64::max),
    });
    if others.is_empty() {
        return Some(Discrimination { one_thing, ..Discrimination::default() });
    }
    if !is_useful(distinguishing_probability(greatest(&first, &others)?.square(&others))) {
        // No phase parts all of them at once: the most probable goes first.
        others.truncate(1);
    }
    let best = greatest(&first, &others)?;
    let near = judge(&nearby(&settable, &best.inputs))?;
    let best = greatest(&near, &others).filter(|other| other.square(&others) > best.square(&others)).unwrap_or(best);
    let repeat = greatest(&repeated, &others);
    let conditions = settable.iter().map(|&(index, _)| {
        (problem.model.inputs[index].name.clone(), setting(&problem.model, index, best.inputs[index]))
    });
    let shown = || std::iter::once(0).chain(others.iter().map(|rival| rival + 1));
    let sensors = template.sensors.iter().enumerate();
    let predicted = |place: usize| shown().map(|rival| best.predictions[rival][place]).collect();
    let experiment = DiscriminatingExperiment {
        between: shown().map(of).collect(),
        conditions: conditions.collect(),
        probability: distinguishing_probability(best.square(&others)),
        repeat_probability: repeat.map_or(0.5, |repeat| distinguishing_probability(repeat.square(&others))),
        limits_ok: best.within_limits,
        near_tested: best.near_tested,
        predictions: sensors
            .map(|(place, sensor)| (sensor.name.clone(), predicted(place)))
            .collect::<BTreeMap<_, Vec<f64>>>(),
    };
    Some(Discrimination { experiment: Some(experiment), one_thing, only_in_transients: None })
}

/// Steady conditions as they were judged.
#[derive(Clone)]
struct Judged {
    inputs: Vec<f64>,
    /// Squared distance of the selected set from each rival.
    squares: Vec<f64>,
    /// Whether no red limit of a node is passed.
    within_limits: bool,
    /// Whether no sensor reads far from all readings so far, but where the node's limits allow it.
    near_tested: bool,
    /// Readings that each rival predicts, SI.
    predictions: Vec<Vec<f64>>,
}

impl Judged {
    /// The least of the squared distances from some rivals.
    fn square(&self, rivals: &[usize]) -> f64 {
        let least = rivals.iter().map(|&rival| self.squares[rival]).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    }
}

/// The best at parting some rivals from the selected set. What the hardware bears goes first: within the limits and near what was
/// tested where a phase there is worth a test, else within the limits.
fn greatest(list: &[Judged], rivals: &[usize]) -> Option<Judged> {
    let of = |is_allowed: &dyn Fn(&Judged) -> bool| {
        let fitting = list.iter().filter(|one| is_allowed(one));
        fitting.reduce(|best, next| if next.square(rivals) > best.square(rivals) { next } else { best })
    };
    let near = of(&|one| one.within_limits && one.near_tested);
    near.filter(|near| is_worth_a_test(distinguishing_probability(near.square(rivals))))
        .or_else(|| of(&|one| one.within_limits))
        .or_else(|| of(&|_| true))
        .cloned()
}

/// A steady measurement of one phase with the sensors of the data; in transients as they are in their first.
fn template(findings: &Findings<'_>) -> Option<Measurement> {
    let measurements = &findings.problem.measurements;
    let steady = measurements.iter().position(|m| matches!(m.rows, Rows::Steady(_)));
    let place = steady.unwrap_or(0);
    let mut measurement = measurements.get(place)?.clone();
    measurement.rows = Rows::Steady(Vec::new());
    measurement.readings.clear();
    for (number, sensor) in measurement.sensors.iter_mut().enumerate() {
        // Steady phases know neither lags, clocks nor correlation, and a model error counts in them as theirs, not as a transient's.
        let estimated = findings.state.noise.iter().find(|own| own.measurement == place && own.sensor == number);
        let wrong = estimated.and_then(|own| Some(own.model_error?.in_steady_phases(own.noise.total())));
        let total = wrong.unwrap_or_else(|| sensor.total_sd());
        sensor.sigma = Some(crate::measurement::Uncertain::Known(total));
        sensor.lag_s = None;
        sensor.behind_s.clear();
        sensor.correlation_time_s = None;
        sensor.white = None;
    }
    Some(measurement)
}

fn at_conditions(template: &Measurement, conditions: &[Vec<f64>]) -> Measurement {
    let phase = |(number, inputs): (usize, &Vec<f64>)| Phase {
        name: format!("condition {number}"),
        inputs: inputs.clone(),
        held_out: false,
        ignored: None,
        stabilisation: None,
    };
    let phases: Vec<Phase> = conditions.iter().enumerate().map(phase).collect();
    let readings = vec![Some(0.0); phases.len() * template.sensors.len()];
    Measurement { rows: Rows::Steady(phases), readings, ..template.clone() }
}

fn judge(
    problem: &Problem,
    rivals: &[&Rival<'_>],
    template: &Measurement,
    conditions: &[Vec<f64>],
) -> Option<Vec<Judged>> {
    let mut all: Vec<Predicted> = Vec::new();
    for rival in rivals {
        // Sensors as this rival changes them.
        let mut own = template.clone();
        let changed = rival.problem.measurements.iter().find(|m| m.name == template.name)?;
        for (sensor, other) in own.sensors.iter_mut().zip(&changed.sensors) {
            sensor.quantity = other.quantity;
        }
        all.push(rival.at(&at_conditions(&own, conditions))?);
    }
    let width = template.sensors.len();
    let predictor = Predictor::new(&rivals[0].problem.model, &[]).ok()?;
    let full = rivals[0].full_parameters(&all[0])?;
    let predicted =
        predictor.predict(&mut predictor.workspace(), &at_conditions(template, conditions), &full).temperatures;
    let nodes = rivals[0].problem.model.nodes.len();
    let is_temperature = |sensor: usize| problem.model.quantities[template.sensors[sensor].quantity].is_temperature;
    let tested = Tested::of(problem);
    let mut judged = Vec::new();
    for (number, inputs) in conditions.iter().enumerate() {
        watch::check();
        let mut squares = Vec::new();
        for (rival, own) in rivals.iter().zip(&all).skip(1) {
            let data = own.likelihood.data();
            let rows: Vec<usize> = (0..own.residuals.len()).filter(|&row| data[row].row == number).collect();
            squares.push(square(&all[0], rival, own, &rows));
        }
        let within = is_within_limits(&problem.model, &predicted[number * nodes..(number + 1) * nodes]);
        let reading = |own: &Predicted| {
            let mut readings = vec![f64::NAN; width];
            for (row, datum) in own.likelihood.data().iter().enumerate().filter(|(_, d)| d.row == number) {
                // The readings stand as 0, so that the residual is minus the prediction in units of the noise.
                let sigma = template.sensors[datum.sensor].sigma.as_ref().map_or(1.0, |sigma| sigma.nominal());
                readings[datum.sensor] = -own.residuals[row] * sigma;
            }
            readings
        };
        let predictions: Vec<Vec<f64>> = all.iter().map(reading).collect();
        let is_meaningless =
            |(sensor, value): (usize, &f64)| is_temperature(sensor) && *value > tested.warmest_k() + MEANINGLESS_K;
        if predictions.iter().any(|readings| readings.iter().enumerate().any(is_meaningless)) {
            continue;
        }
        let is_near =
            |(sensor, value): (usize, &f64)| tested.is_near(&problem.model, template.sensors[sensor].quantity, *value);
        let near_tested = predictions.iter().all(|readings| readings.iter().enumerate().all(is_near));
        judged.push(Judged { inputs: inputs.clone(), squares, within_limits: within, near_tested, predictions });
    }
    Some(judged)
}

/// Whether temperatures of the nodes, K, pass no red limit.
pub(super) fn is_within_limits(model: &Model, temperatures: &[f64]) -> bool {
    model.nodes.iter().zip(temperatures).all(|(node, &temperature)| {
        !node.limits.red.is_some_and(|[lower, upper]| temperature < lower || temperature > upper)
    })
}

/// Corners of the ranges, and Sobol points within.
fn spread(settable: &[(usize, [f64; 2])], nominal: &[f64]) -> Vec<Vec<f64>> {
    let mut conditions = Vec::new();
    if settable.len() <= MOST_CORNERS {
        for corner in 0..1_usize << settable.len() {
            let mut inputs = nominal.to_vec();
            for (bit, &(index, range)) in settable.iter().enumerate() {
                inputs[index] = range[corner >> bit & 1];
            }
            conditions.push(inputs);
        }
    }
    conditions
        .extend(points(settable, nominal, CONDITIONS, |_, range, share| range[0] + share * (range[1] - range[0])));
    conditions
}

/// Points within a tenth of the ranges round the best.
fn nearby(settable: &[(usize, [f64; 2])], centre: &[f64]) -> Vec<Vec<f64>> {
    points(settable, centre, NEARBY, |now, range, share| {
        (now + 0.2 * (share - 0.5) * (range[1] - range[0])).max(range[0]).min(range[1])
    })
}

fn points(
    settable: &[(usize, [f64; 2])],
    from: &[f64],
    count: usize,
    place: impl Fn(f64, [f64; 2], f64) -> f64,
) -> Vec<Vec<f64>> {
    let key = StreamKey::new(0, "separating experiment", "conditions");
    let points = Points::new(PointKind::Sobol, key, count, settable.len())
        .or_else(|_| Points::new(PointKind::MonteCarlo, key, count, settable.len()));
    let Ok(points) = points else { return Vec::new() };
    let mut row = vec![0.0; settable.len()];
    (0..count)
        .map(|number| {
            points.fill_row(number, &mut row);
            let mut inputs = from.to_vec();
            for (&(index, range), share) in settable.iter().zip(&row) {
                inputs[index] = place(from[index], range, *share);
            }
            inputs
        })
        .collect()
}

/// Conditions of the phases that were measured and fitted.
fn old_conditions(problem: &Problem) -> Vec<Vec<f64>> {
    let phases = problem.measurements.iter().filter_map(|measurement| match &measurement.rows {
        Rows::Steady(phases) => Some(phases),
        Rows::Transient { .. } => None,
    });
    phases.flatten().filter(|p| !p.held_out && p.ignored.is_none()).map(|phase| phase.inputs.clone()).collect()
}
