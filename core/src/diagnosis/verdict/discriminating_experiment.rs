//! The experiment that parts rivals: a steady phase, within the stated ranges of the inputs that can be set, in which the
//! rivals' predictions lie furthest apart once each has been fitted to the old data and the new.
//!
//! With the whitened difference `m` of two rivals' predictions, `F` the derivatives of the second's and `C` the covariance
//! of its parameters after the old data: `delta^2 = m' (I + F C F')^-1 m`, and the better one is recognised with probability
//! `Phi(delta / 2)` (Box & Hill 1967, for two hypotheses of equal probability).

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use crate::diagnosis::linearisation::signature::linearise;
use crate::diagnosis::output::{DiscriminatingExperiment, OneThing, Setting};
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::{Problem, Refit};
use crate::inference::information::separation;
use crate::inference::likelihood::{Definition, Likelihood};
use crate::inference::target::{LeastSquares, Target};
use crate::math::cholesky;
use crate::math::special::normal_cdf;
use crate::measurement::prediction::Predictor;
use crate::measurement::{Measurement, Phase, Rows};
use crate::random::{PointKind, Points, StreamKey};
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
const ROOM_K: f64 = 293.15;
/// Most rivals that are considered.
const MOST_RIVALS: usize = 5;

/// Probability of telling two hypotheses apart below which an experiment is little better than a coin.
const USEFUL: f64 = 0.6;

/// What would part the selected set and its rivals.
#[derive(Default)]
pub(crate) struct Discrimination {
    /// The experiment that parts them, as far as one does.
    pub experiment: Option<DiscriminatingExperiment>,
    /// Those that none parts.
    pub one_thing: Option<OneThing>,
}

/// The probability with which two hypotheses of so large a squared distance are told apart.
pub fn distinguishing_probability(square: f64) -> f64 {
    normal_cdf(0.5 * square.max(0.0).sqrt())
}

/// Whether an experiment with this probability of telling hypotheses apart is worth its cost.
pub fn is_useful(probability: f64) -> bool {
    probability >= USEFUL
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
    let settable: Vec<(usize, [f64; 2])> = (problem.model.inputs.iter().enumerate())
        .filter_map(|(index, input)| Some((index, input.range.filter(|r| input.settable && r[0] < r[1])?)))
        .collect();
    if settable.is_empty() {
        return None;
    }
    let template = template(problem)?;
    let nominal: Vec<f64> = problem.model.inputs.iter().map(|input| input.nominal).collect();
    let rivals: Vec<Rival> = fits.iter().map(|fit| Rival::new(problem, fit)).collect::<Option<_>>()?;
    let judge = |conditions: &[Vec<f64>]| judge(problem, &rivals, &template, conditions);
    let first = judge(&spread(&settable, &nominal))?;
    let old = old_conditions(problem);
    let repeated = if old.is_empty() { Vec::new() } else { judge(&old)? };
    let of = |fit: &Refit| {
        let ids: Vec<&str> = fit.effects.iter().map(|&effect| findings.id(effect)).collect();
        ids.join(" + ")
    };
    // Of each rival by itself: whether any phase parts it from the selected set.
    let probability = |list: &[Judged], rival: usize| {
        greatest(list, &[rival]).map_or(0.5, |best| distinguishing_probability(best.square(&[rival])))
    };
    let mut alike = Vec::new();
    let mut others = Vec::new();
    for rival in 0..fits.len() - 1 {
        let (best, again) = (probability(&first, rival), probability(&repeated, rival));
        if is_useful(best) {
            others.push(rival);
        } else {
            alike.push((rival, best, again));
        }
    }
    let one_thing = (!alike.is_empty()).then(|| OneThing {
        sets: std::iter::once(of(fits[0])).chain(alike.iter().map(|&(rival, _, _)| of(fits[rival + 1]))).collect(),
        probability: alike.iter().map(|own| own.1).fold(0.5, f64::max),
        repeat_probability: alike.iter().map(|own| own.2).fold(0.5, f64::max),
    });
    if others.is_empty() {
        return Some(Discrimination { experiment: None, one_thing });
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
        let input = &problem.model.inputs[index];
        let unit =
            crate::expression::Unit::parse(&input.unit).map(|unit| unit.dimension.to_string()).unwrap_or_default();
        (input.name.clone(), Setting { value: best.inputs[index], unit })
    });
    let told_apart = || std::iter::once(0).chain(others.iter().map(|rival| rival + 1));
    let sensors = template.sensors.iter().enumerate();
    let predicted = |place: usize| told_apart().map(|rival| best.predictions[rival][place]).collect();
    let experiment = DiscriminatingExperiment {
        between: told_apart().map(|rival| of(fits[rival])).collect(),
        conditions: conditions.collect(),
        probability: distinguishing_probability(best.square(&others)),
        repeat_probability: repeat.map_or(0.5, |repeat| distinguishing_probability(repeat.square(&others))),
        limits_ok: best.within_limits,
        predictions: sensors
            .map(|(place, sensor)| (sensor.name.clone(), predicted(place)))
            .collect::<BTreeMap<_, Vec<f64>>>(),
    };
    Some(Discrimination { experiment: Some(experiment), one_thing })
}

/// A rival hypothesis at its fit.
struct Rival<'a> {
    fit: &'a Refit,
    problem: Problem,
    /// Covariance of its unknowns after the old data.
    covariance: DMatrix<f64>,
}

impl<'a> Rival<'a> {
    fn new(problem: &Problem, fit: &'a Refit) -> Option<Self> {
        let with = problem.with(fit).ok()?;
        let likelihood = with.hypothesis(&[], 1.0).ok()?.likelihood(&with).ok()?;
        let linear = linearise(&likelihood, &fit.unknowns).ok()?;
        let n = linear.parameters();
        let free: Vec<usize> = (0..n).filter(|&i| linear.lower[i] < 0.0 && linear.upper[i] > 0.0).collect();
        let k = free.len();
        let mut information = vec![0.0; k * k];
        for row in linear.jacobian.chunks_exact(n.max(1)) {
            for (a, &i) in free.iter().enumerate() {
                for (b, &j) in free.iter().enumerate() {
                    information[a * k + b] += row[i] * row[j];
                }
            }
        }
        // What the data leave open is left to the box: a parameter cannot be less certain than its range.
        for (a, &i) in free.iter().enumerate() {
            let width = linear.upper[i] - linear.lower[i];
            if width.is_finite() && width > 0.0 {
                information[a * k + a] += 12.0 / (width * width);
            }
        }
        cholesky::factor(&mut information, k).ok()?;
        let inverse = cholesky::inverse(&information, k);
        let mut covariance = DMatrix::zeros(n, n);
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                covariance[(i, j)] = inverse[a * k + b];
            }
        }
        Some(Self { fit, problem: with, covariance })
    }

    /// Whitened predictions and derivatives at steady conditions; rows are in the order of the likelihood's data.
    fn at(&self, measurement: &Measurement) -> Option<(Likelihood, Vec<f64>, Vec<f64>)> {
        let problem = Problem { measurements: vec![measurement.clone()], ..self.problem.clone() };
        let likelihood = Likelihood::new(&Definition {
            model: &problem.model,
            priors: &problem.priors,
            parameters: &problem.parameters,
            measurements: &[measurement],
            input_errors: &problem.input_errors,
        })
        .ok()?;
        let likelihood = problem.informed(likelihood, &[]);
        let known = self.fit.by_name();
        let at: Vec<f64> = likelihood.names().iter().map(|name| known.get(name).copied()).collect::<Option<_>>()?;
        let linear = linearise(&likelihood, &at).ok()?;
        let (rows, n) = (likelihood.residual_count(), linear.parameters());
        // In the order of the fit's unknowns, some of which steady phases do not have.
        let all = self.fit.names.len();
        let mut jacobian = vec![0.0; rows * all];
        for (column, name) in likelihood.names().iter().enumerate() {
            let place = self.fit.names.iter().position(|known| known == name)?;
            for row in 0..rows {
                jacobian[row * all + place] = linear.jacobian[row * n + column];
            }
        }
        Some((likelihood, linear.residuals[..rows].to_vec(), jacobian))
    }
}

/// Steady conditions as they were judged.
#[derive(Clone)]
struct Judged {
    inputs: Vec<f64>,
    /// Squared distance of the selected set from each rival.
    squares: Vec<f64>,
    within_limits: bool,
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

/// The best within the limits at parting some rivals from the selected set.
fn greatest(list: &[Judged], rivals: &[usize]) -> Option<Judged> {
    let within = list.iter().any(|one| one.within_limits);
    let fitting = list.iter().filter(|one| one.within_limits || !within);
    fitting.reduce(|best, next| if next.square(rivals) > best.square(rivals) { next } else { best }).cloned()
}

/// A steady measurement of one phase with the sensors of the data; in transients as they are in their first.
fn template(problem: &Problem) -> Option<Measurement> {
    let steady = problem.measurements.iter().find(|m| matches!(m.rows, Rows::Steady(_)));
    let mut measurement = steady.or(problem.measurements.first())?.clone();
    measurement.rows = Rows::Steady(Vec::new());
    measurement.readings.clear();
    for sensor in &mut measurement.sensors {
        // Steady phases know neither lags nor correlation.
        let part = |value: &Option<crate::measurement::Uncertain>| value.as_ref().map_or(0.0, |v| v.nominal());
        let total = (part(&sensor.sigma) * part(&sensor.sigma) + part(&sensor.white) * part(&sensor.white)).sqrt();
        sensor.sigma = Some(crate::measurement::Uncertain::Known(total));
        sensor.lag_s = None;
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
    rivals: &[Rival<'_>],
    template: &Measurement,
    conditions: &[Vec<f64>],
) -> Option<Vec<Judged>> {
    let mut all = Vec::new();
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
    let full = all[0].0.full_parameters(&ordered(&all[0].0, rivals[0].fit)?);
    let predicted =
        predictor.predict(&mut predictor.workspace(), &at_conditions(template, conditions), &full).temperatures;
    let nodes = rivals[0].problem.model.nodes.len();
    let is_temperature = |sensor: usize| problem.model.quantities[template.sensors[sensor].quantity].is_temperature;
    let warmest = warmest_reading(problem);
    let mut judged = Vec::new();
    for (number, inputs) in conditions.iter().enumerate() {
        watch::check();
        let mut squares = Vec::new();
        for (rival, (likelihood, residuals, jacobian)) in rivals.iter().zip(&all).skip(1) {
            let rows: Vec<usize> = (0..residuals.len()).filter(|&row| likelihood.data()[row].row == number).collect();
            let n = rival.fit.names.len();
            let of = |residuals: &[f64]| -> Vec<f64> { rows.iter().map(|&row| residuals[row]).collect() };
            let slopes: Vec<f64> = rows.iter().flat_map(|row| &jacobian[row * n..(row + 1) * n]).copied().collect();
            // Whitened; residuals of readings of 0 are minus the predictions, and the distance knows no sign.
            let noise: Vec<f64> =
                (0..rows.len() * rows.len()).map(|k| f64::from(u8::from(k % (rows.len() + 1) == 0))).collect();
            let mean = of(residuals);
            let other = separation::Rival {
                mean: &mean,
                derivatives: &slopes,
                covariance: rival.covariance.as_slice(),
                parameters: n,
            };
            let own = separation::from_truth(&of(&all[0].1), &other, &noise).map_or(0.0, |own| own.distance_squared);
            squares.push(own);
        }
        let within = (0..nodes.min(problem.model.nodes.len())).all(|node| {
            let temperature = predicted[number * nodes + node];
            let red = problem.model.nodes[node].limits.red;
            !red.is_some_and(|[lower, upper]| temperature < lower || temperature > upper)
        });
        let reading = |(likelihood, residuals, _): &(Likelihood, Vec<f64>, Vec<f64>)| {
            let mut readings = vec![f64::NAN; width];
            for (row, datum) in likelihood.data().iter().enumerate().filter(|(_, d)| d.row == number) {
                // The readings stand as 0, so that the residual is minus the prediction in units of the noise.
                let sigma = template.sensors[datum.sensor].sigma.as_ref().map_or(1.0, |sigma| sigma.nominal());
                readings[datum.sensor] = -residuals[row] * sigma;
            }
            readings
        };
        let predictions: Vec<Vec<f64>> = all.iter().map(reading).collect();
        let is_meaningless =
            |(sensor, value): (usize, &f64)| is_temperature(sensor) && *value > warmest + MEANINGLESS_K;
        if predictions.iter().any(|readings| readings.iter().enumerate().any(is_meaningless)) {
            continue;
        }
        judged.push(Judged { inputs: inputs.clone(), squares, within_limits: within, predictions });
    }
    Some(judged)
}

/// The highest temperature that was read, K; that of a room where none was.
fn warmest_reading(problem: &Problem) -> f64 {
    let readings = problem.measurements.iter().flat_map(|own| {
        let of_temperature = |&sensor: &usize| problem.model.quantities[own.sensors[sensor].quantity].is_temperature;
        let sensors = (0..own.sensors.len()).filter(of_temperature);
        sensors.flat_map(move |sensor| (0..own.len()).filter_map(move |row| own.reading(row, sensor)))
    });
    readings.fold(ROOM_K, f64::max)
}

fn ordered(likelihood: &Likelihood, fit: &Refit) -> Option<Vec<f64>> {
    let known = fit.by_name();
    likelihood.names().iter().map(|name| known.get(name).copied()).collect()
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
