//! The signatures of all effects against differences of their own likelihoods.

use std::sync::Arc;

use bmv::diagnosis::fits::refit::Begin;
use bmv::diagnosis::linearisation::signature::{Unseen, directions, linearise};
use bmv::diagnosis::{Direction, Problem};
use bmv::effect::{Candidate, SensorPlace, Site, candidates};
use bmv::inference::likelihood::{InputError, Likelihood};
use bmv::inference::target::{LeastSquares, Target};
use bmv::measurement::{Initial, InputColumn, InputTable, Measurement, Phase, Rows, Sensor, Uncertain};
use bmv::random::{Distribution, StreamKey};
use bmv::thermal::Model;

use super::effects::{catalogue, groups, model, sensors};

/// Conditions of the phases: plate and shroud (K), power (W), pressure (Pa), current (A).
const PHASES: [[f64; 5]; 4] = [
    [290.0, 120.0, 6.0, 2.0, 0.8],
    [305.0, 120.0, 3.0, 1.2, 0.8],
    [270.0, 150.0, 8.0, 2.8, 0.5],
    [290.0, 90.0, 4.0, 2.0, 1.1],
];

fn sensor(place: &SensorPlace, sigma: Uncertain) -> Sensor {
    Sensor {
        name: place.name.clone(),
        quantity: place.quantity,
        unit: "K".into(),
        sigma: Some(sigma),
        bias: None,
        lag_s: None,
        behind_s: Vec::new(),
        correlation_time_s: None,
        white: None,
    }
}

fn measurement(name: &str, rows: Rows, sensors: Vec<Sensor>, readings: Vec<Option<f64>>) -> Measurement {
    let (file, sha256) = (String::new(), String::new());
    Measurement {
        name: name.into(),
        rows,
        sensors,
        readings,
        file,
        sha256,
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    }
}

/// Phases of which the last is held out and one reading is missing.
fn steady(model: &Model) -> Measurement {
    let rows = PHASES.iter().enumerate().map(|(k, inputs)| Phase {
        name: format!("P{k}"),
        inputs: inputs.to_vec(),
        held_out: k == 3,
        ignored: None,
        stabilisation: None,
    });
    let inferred = Uncertain::Inferred(Distribution::LogUniform { lower: 0.05, upper: 1.0 });
    let sensors: Vec<Sensor> = (sensors(model).iter().zip([Uncertain::Known(0.2), inferred, Uncertain::Known(0.1)]))
        .map(|(place, sigma)| sensor(place, sigma))
        .collect();
    let mut readings: Vec<Option<f64>> =
        (0..12).map(|k| Some([280.0, 262.0, 270.0][k % 3] + f64::from(k as u8 % 5))).collect();
    readings[4] = None;
    measurement("balance", Rows::Steady(rows.collect()), sensors, readings)
}

/// A transient from fitted temperatures: the power and the plate step, one sensor's noise is correlated.
fn transient(model: &Model) -> Measurement {
    let times_s: Vec<f64> = (0..25).map(|k| 120.0 * f64::from(k)).collect();
    let step = |low: f64, high: f64| (0..25).map(|k| if (6..16).contains(&k) { high } else { low }).collect();
    let columns = vec![
        InputColumn { input: 2, values: step(3.0, 8.0), hold: true },
        InputColumn { input: 0, values: step(288.0, 292.0), hold: false },
    ];
    let inputs = InputTable { times_s, base: PHASES[0].to_vec(), columns };
    let mut values: Vec<Uncertain> = model.nodes.iter().map(|_| Uncertain::Known(280.0)).collect();
    values[2] = Uncertain::Inferred(Distribution::Uniform { lower: 250.0, upper: 310.0 });
    let initial = Initial::Temperatures { values, shared: vec![], balanced: vec![] };
    let mut sensors: Vec<Sensor> = sensors(model).iter().map(|place| sensor(place, Uncertain::Known(0.1))).collect();
    sensors[0].correlation_time_s = Some(Uncertain::Known(300.0));
    sensors[1].bias = Some(Uncertain::Inferred(Distribution::Normal { mean: 0.0, sd: 0.2, lower: None, upper: None }));
    let readings = (0..75).map(|k| Some(275.0 + f64::from(k as u8 % 7))).collect();
    let rows = Rows::Transient { inputs, initial, held_out: vec![false; 25], ignored: vec![None; 25] };
    measurement("course", rows, sensors, readings)
}

/// 1200 rows of an orbit: the plate swings, the power changes with every row.
fn long(model: &Model) -> Measurement {
    let count = 1200;
    let times_s: Vec<f64> = (0..count).map(|k| 60.0 * f64::from(k)).collect();
    let phase = |t: f64| 2.0 * std::f64::consts::PI * t / 5700.0;
    let plate = times_s.iter().map(|&t| 290.0 + 8.0 * libm::sin(phase(t))).collect();
    let power = (0..count).map(|k| 5.0 + 3.0 * libm::cos(phase(60.0 * f64::from(k))) + f64::from(k % 3)).collect();
    let columns =
        vec![InputColumn { input: 2, values: power, hold: true }, InputColumn { input: 0, values: plate, hold: false }];
    let inputs = InputTable { times_s, base: PHASES[0].to_vec(), columns };
    let values = model.nodes.iter().map(|_| Uncertain::Known(280.0)).collect();
    let initial = Initial::Temperatures { values, shared: vec![], balanced: vec![] };
    let sensors: Vec<Sensor> = sensors(model).iter().map(|place| sensor(place, Uncertain::Known(0.1))).collect();
    let readings = (0..3 * count).map(|k| Some(275.0 + f64::from(k % 7))).collect();
    // The last rows are held out, so that the rows to fit end between two that are kept.
    let held_out = (0..count).map(|k| k > 1150).collect();
    measurement("orbits", Rows::Transient { inputs, initial, held_out, ignored: vec![None; 1200] }, sensors, readings)
}

fn problem(mut measurements: Vec<Measurement>, input_errors: Vec<InputError>) -> Problem {
    let mut model = model();
    model.set_clocks(&measurements.clone(), &mut measurements);
    let catalogue = Arc::new(catalogue());
    let candidates = candidates(&model, &groups(&model), &sensors(&model), &catalogue);
    Problem {
        model: Arc::new(model),
        priors: vec![Distribution::LogNormal { median: 0.6, factor: 1.3 }],
        parameters: vec![0],
        measurements,
        input_errors,
        catalogue,
        candidates: Arc::new(candidates),
        joint: Vec::new(),
        most_steps: Vec::new(),
        noise_freedom: None,
        is_misspecified: false,
        independent_readings: 0.0,
        considered: Vec::new(),
        working_temperatures_k: Default::default(),
        places: Default::default(),
        missing_probability: Default::default(),
        tolerance: 1.0,
    }
}

/// The likelihood without effects, and a point.
fn fit(problem: &Problem) -> (Likelihood, Vec<f64>) {
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(problem).unwrap();
    let mut unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.4)).collect();
    for (name, value) in likelihood.names().iter().zip(&mut unknowns) {
        if name.contains(".start.") {
            *value = 281.0;
        }
    }
    (likelihood, unknowns)
}

/// Residuals of the candidate's own likelihood with the parameters of the effect at `values`.
struct Own {
    likelihood: Likelihood,
    unknowns: Vec<f64>,
    first: usize,
    inferred: Vec<bool>,
}

impl Own {
    fn new(problem: &Problem, candidate: usize, base: &Likelihood, at: &[f64]) -> Self {
        let hypothesis = problem.hypothesis(&[candidate], 1.0).unwrap();
        let likelihood = hypothesis.likelihood(problem).unwrap();
        let unknowns = (likelihood.names().iter().zip(likelihood.priors()))
            .map(|(name, prior)| match base.names().iter().position(|own| own == name) {
                Some(place) => at[place],
                None if name.contains(".start.") => 281.0,
                None => prior.quantile(0.5),
            })
            .collect();
        let range = hypothesis.amplitudes[0].clone();
        let inferred = hypothesis.priors[range].iter().map(|prior| !prior.is_fixed()).collect();
        Self { likelihood, unknowns, first: base.model_parameters(), inferred }
    }

    fn residuals(&self, values: &[f64]) -> Vec<f64> {
        let unknowns = self.unknowns_at(values);
        let mut residuals = vec![0.0; self.likelihood.residual_count()];
        self.likelihood.residuals(&unknowns, &mut self.likelihood.workspace(), &mut residuals).expect("evaluates");
        residuals
    }
}

impl Own {
    /// The unknowns with the parameters of the effect at `values`.
    fn unknowns_at(&self, values: &[f64]) -> Vec<f64> {
        let mut unknowns = self.unknowns.clone();
        let moved = values.iter().zip(&self.inferred).filter(|(_, inferred)| **inferred);
        for (place, (value, _)) in moved.enumerate() {
            unknowns[self.first + place] = *value;
        }
        unknowns
    }

    /// Exact slopes of the predictions, in standard deviations, by a parameter of the effect at `values`.
    fn slopes(&self, values: &[f64], position: usize) -> Vec<f64> {
        let unknowns = self.unknowns_at(values);
        let place = self.first + self.inferred[..position].iter().filter(|inferred| **inferred).count();
        let (rows, n) = (self.likelihood.residual_count(), unknowns.len());
        let (mut residuals, mut jacobian, mut gradient) = (vec![0.0; rows], vec![0.0; rows * n], vec![0.0; n]);
        let mut memory = self.likelihood.workspace();
        self.likelihood.jacobian(&unknowns, &mut memory, &mut residuals, &mut jacobian, &mut gradient).unwrap();
        jacobian.iter().skip(place).step_by(n).map(|slope| -slope).collect()
    }
}

fn amplitude_positions(problem: &Problem, candidate: &Candidate) -> (Vec<usize>, Vec<f64>, Vec<f64>) {
    let effect = problem.catalogue.get(&candidate.effect).unwrap();
    let parameters = effect.parameters(&problem.model, &candidate.bound);
    let shapes = (0..parameters.len()).filter(|&i| !parameters[i].amplitude).collect();
    let values = parameters.iter().map(|p| if p.amplitude { 0.0 } else { p.nominal }).collect();
    (shapes, values, parameters.iter().map(|p| p.plausible).collect())
}

/// Largest error, as a share of the largest slope, of a row within a change at a date.
const AT_A_DATE: f64 = 0.1;

/// Compares a direction with differences, which are one-sided and of second order: what is positive stays so. So many readings may lie
/// within a change at a date.
fn check(problem: &Problem, own: &Own, direction: &Direction, step: f64, tolerance: f64, at_a_date: usize) {
    let candidate = &problem.candidates[direction.candidate];
    let (shapes, mut values, plausible) = amplitude_positions(problem, candidate);
    for (&position, value) in shapes.iter().zip(&direction.shape) {
        values[position] = *value;
    }
    if candidate.effect == "hidden-node" {
        values[0] = 50.0;
    }
    let rows = own.likelihood.residual_count();
    let none = own.residuals(&values);
    for (amplitude, &position) in direction.parameters.iter().enumerate() {
        // What is plausible of a heat of melting is far more than the node stores over the width: there it is no small step.
        let share = if candidate.effect == "latent-heat" { 0.01 } else { 1.0 };
        let h = share * step * plausible[position];
        let at = |by: f64| {
            let mut values = values.clone();
            values[position] = by;
            own.residuals(&values)
        };
        let (one, two) = (at(h), at(2.0 * h));
        let column = direction.column(amplitude);
        assert!(column[rows..].iter().all(|value| *value == 0.0), "{}: rows of priors", candidate.id);
        let largest = column.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut near = 0;
        for row in 0..rows {
            let difference = -(4.0 * one[row] - two[row] - 3.0 * none[row]) / (2.0 * h);
            let error = (difference - column[row]).abs();
            let is_near = error > tolerance * largest + 1e-7 / h && error <= AT_A_DATE * largest && near < at_a_date;
            near += usize::from(is_near);
            assert!(
                is_near || error <= tolerance * largest + 1e-7 / h,
                "{} {position} at {:?}, row {row}: {} against {difference} (largest {largest})",
                candidate.id,
                direction.shape,
                column[row]
            );
        }
    }
}

fn reason(problem: &Problem, unseen: &[Unseen], id: &str) -> String {
    let position = problem.candidates.iter().position(|candidate| candidate.id == id).expect("there");
    unseen.iter().find(|one| one.candidate == position).expect("unseen").reason.to_string()
}

/// Every candidate is seen or said to be unseen, and every smooth direction is the slope of its own likelihood. A
/// step of 1e-4 of a plausible amplitude leaves an error of the square of what it shifts: 2e-3 of a conductance of the
/// blanket, which couples weakest.
#[test]
fn steady_directions_are_the_slopes_of_each_effects_likelihood() {
    let problem = problem(vec![steady(&model())], vec![]);
    let (likelihood, at) = fit(&problem);
    let (found, unseen) = directions(&problem, &likelihood, &at).unwrap();
    for position in 0..problem.candidates.len() {
        let seen = found.iter().any(|direction| direction.candidate == position);
        let not = unseen.iter().filter(|one| one.candidate == position).count();
        assert_eq!(usize::from(seen) + not, 1, "{}", problem.candidates[position].id);
    }
    assert!(found.windows(2).all(|two| two[0].candidate <= two[1].candidate));
    assert_eq!(reason(&problem, &unseen, "thermal-mass:box"), "steady phases do not see heat capacities");
    assert_eq!(reason(&problem, &unseen, "hidden-node:box"), "steady phases do not see heat capacities");
    assert_eq!(reason(&problem, &unseen, "sensor-lag:TC box"), "steady phases do not see the lag of a sensor");
    assert_eq!(reason(&problem, &unseen, "sensor-drift:TC box"), "steady phases do not see what changes with time");
    let mut smooth = 0;
    let mut last: Option<(usize, Own)> = None;
    for direction in found.iter().filter(|direction| !direction.parameters.is_empty()) {
        if last.as_ref().is_none_or(|(candidate, _)| *candidate != direction.candidate) {
            last = Some((direction.candidate, Own::new(&problem, direction.candidate, &likelihood, &at)));
        }
        check(&problem, &last.as_ref().unwrap().1, direction, 1e-4, 1e-3, 0);
        smooth += 1;
    }
    assert!(smooth > 200, "{smooth}");
}

/// Compares what is tried at finite values with what the refitted model would predict there; the effects of those compared.
fn compared_probes(problem: &Problem) -> Vec<String> {
    let (likelihood, at) = fit(problem);
    let (found, _) = directions(problem, &likelihood, &at).unwrap();
    let mut base = vec![0.0; likelihood.residual_count()];
    likelihood.residuals(&at, &mut likelihood.workspace(), &mut base).unwrap();
    let mut seen = Vec::new();
    for direction in found.iter().filter(|direction| !direction.probe.is_empty()) {
        let candidate = &problem.candidates[direction.candidate];
        if seen.iter().filter(|effect| **effect == candidate.effect).count() > 3 {
            continue;
        }
        seen.push(candidate.effect.clone());
        let own = Own::new(problem, direction.candidate, &likelihood, &at);
        let residuals = own.residuals(&direction.probe);
        let largest = direction.columns.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for row in 0..base.len() {
            let difference = base[row] - residuals[row] - direction.columns[row];
            // The steady solutions are found from other starts.
            assert!(difference.abs() <= 1e-6 * largest.max(1.0), "{} row {row}: {difference}", candidate.id);
        }
        assert!(direction.columns[base.len()..].iter().all(|value| *value == 0.0));
        assert_eq!((direction.lower[0], direction.upper[0], direction.plausible[0]), (0.0, f64::INFINITY, 1.0));
    }
    seen
}

#[test]
fn probes_are_finite_differences() {
    let seen = compared_probes(&problem(vec![steady(&model()), transient(&model())], vec![]));
    for effect in ["hidden-node", "path-capacity", "heater-capacity", "cooler-contact", "sensor-lag", "thermal-mass"] {
        assert!(seen.iter().any(|own| own == effect), "{effect}: {seen:?}");
    }
}

/// Clocks show rows that are held out, add to what is declared of a sensor, and need nothing of a run that is held out as a whole.
#[test]
fn probes_of_clocks_are_finite_differences_where_rows_are_held_out() {
    let (mut own, mut unseen) = (transient(&model()), long(&model()));
    // It shows the end of the record, so that both are integrated to there by the same steps.
    own.sensors[2].behind_s = vec![Uncertain::Known(960.0)];
    if let Rows::Transient { held_out, .. } = &mut own.rows {
        held_out[17..].fill(true);
    }
    if let Rows::Transient { held_out, .. } = &mut unseen.rows {
        held_out.fill(true);
    }
    let mut problem = problem(vec![own, unseen], vec![]);
    problem.most_steps = vec![5000, 1];
    let of_times = ["sensor-lag", "sensor-clock"];
    Arc::make_mut(&mut problem.candidates).retain(|candidate| of_times.contains(&candidate.effect.as_str()));
    let seen = compared_probes(&problem);
    for effect in of_times {
        assert!(seen.iter().filter(|own| *own == effect).count() > 2, "{effect}: {seen:?}");
    }
}

/// In a transient the derivatives are those of the discrete solution with its steps held: against differences over
/// steps chosen anew, which are exact to the error control (3e-7) over the step.
#[test]
fn transient_directions_are_the_slopes_of_each_effects_likelihood() {
    let mut problem = problem(vec![steady(&model()), transient(&model())], vec![]);
    let mut seen: Vec<String> = Vec::new();
    Arc::make_mut(&mut problem.candidates).retain(|candidate| {
        let new =
            !seen.contains(&candidate.effect) || candidate.where_kind == "sensor" || candidate.where_kind == "group";
        seen.push(candidate.effect.clone());
        new
    });
    let (likelihood, at) = fit(&problem);
    let (found, _) = directions(&problem, &likelihood, &at).unwrap();
    let mut smooth = 0;
    for direction in found.iter().filter(|direction| !direction.parameters.is_empty()) {
        let own = Own::new(&problem, direction.candidate, &likelihood, &at);
        // The steps of the baseline model know nothing of a change within 0.4 % of the record: the three sensors' readings there, and next to
        // it, are nearly right.
        let effect = problem.candidates[direction.candidate].effect.as_str();
        let is_dated = ["dated-load", "dated-conductance"].contains(&effect);
        // The same changes by the clock of a run: here over 12 s, a tenth of a step, and at the very instant of a row.
        if !["event-load", "event-conductance"].contains(&effect) {
            check(&problem, &own, direction, 0.03, 0.02, if is_dated { 6 } else { 0 });
        }
        smooth += 1;
    }
    assert!(smooth > 40, "{smooth}");
}

/// What other steps of the solver make of a temperature, in the sensors' standard deviations: 3e-7 of 300 K over 0.1 K, twice.
const STEPS_ANEW: f64 = 2e-3;

/// The slopes by heat, temperature and width of melting in both nodes of a group that stores twice what these do, each at its own
/// temperature: against central differences over steps of the solver that are chosen anew.
#[test]
fn slopes_of_a_group_that_melts_are_differences() {
    let problem = problem(vec![transient(&model())], vec![]);
    let (likelihood, at) = fit(&problem);
    let find = |id: &str| problem.candidates.iter().position(|candidate| candidate.id == id).expect("there");
    let own = Own::new(&problem, find("latent-heat:surfaces"), &likelihood, &at);
    let values = [5000.0, 283.0, 3.0];
    let without = own.residuals(&[0.0, 283.0, 3.0]);
    let felt = own.residuals(&values).iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(felt > 10.0, "{felt} standard deviations");
    for (position, h) in [500.0, 0.2, 0.2].into_iter().enumerate() {
        let moved = |by: f64| {
            let mut values = values;
            values[position] += by;
            own.residuals(&values)
        };
        let (above, below) = (moved(h), moved(-h));
        let slopes = own.slopes(&values, position);
        let largest = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        assert!(largest > 0.0);
        for (row, slope) in slopes.iter().enumerate() {
            let difference = (below[row] - above[row]) / (2.0 * h);
            let allowed = 1e-2 * largest + STEPS_ANEW / (2.0 * h);
            assert!((difference - slope).abs() < allowed, "{position} {row}: {slope} {difference} ({largest})");
        }
    }
}

/// The swap exchanges predictions; the noise stays with the channel.
#[test]
fn exchanged_channels_exchange_predictions() {
    let problem = problem(vec![steady(&model())], vec![]);
    let (likelihood, at) = fit(&problem);
    let (found, _) = directions(&problem, &likelihood, &at).unwrap();
    let id = "swapped-channels:TC box:TC detector";
    let swap = found.iter().find(|direction| problem.candidates[direction.candidate].id == id).expect("there");
    let mut residuals = vec![0.0; likelihood.residual_count()];
    likelihood.residuals(&at, &mut likelihood.workspace(), &mut residuals).unwrap();
    let reading = |row: usize, sensor: usize| problem.measurements[0].reading(row, sensor).unwrap();
    for (position, datum) in likelihood.data().iter().enumerate() {
        let sigma = [0.2, f64::NAN, 0.1];
        let find = |sensor: usize| likelihood.data().iter().position(|d| d.row == datum.row && d.sensor == sensor);
        let predicted = |sensor: usize| reading(datum.row, sensor) - sigma[sensor] * residuals[find(sensor).unwrap()];
        let expected = match datum.sensor {
            0 => (predicted(2) - predicted(0)) / sigma[0],
            2 => (predicted(0) - predicted(2)) / sigma[2],
            _ => 0.0,
        };
        assert!((swap.columns[position] - expected).abs() < 1e-9 * expected.abs().max(1.0), "{position}");
    }
}

/// The step at the fit: residuals follow `r - J d` in natural coordinates, priors are rows, bounds are those of the
/// step, and exactly 0 at a bound.
#[test]
fn the_linear_problem_is_that_of_the_fit() {
    let errors: Vec<InputError> = vec![
        InputError { sigma: Some(0.3), bias: None },
        InputError::default(),
        InputError { sigma: None, bias: Some(Distribution::Uniform { lower: -0.5, upper: 0.5 }) },
    ];
    let problem = problem(vec![steady(&model()), transient(&model())], errors);
    let (likelihood, mut at) = fit(&problem);
    let place = |name: &str| likelihood.names().iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}"));
    let (bias, sigma, conductance) = (place("Q.bias"), place("balance.TC panel.sigma"), place("G"));
    at[bias] = 0.5 - 1e-11;
    let linear = linearise(&likelihood, &at).unwrap();
    let n = linear.parameters();
    assert_eq!((linear.upper[bias], linear.lower[bias]), (0.0, -1.0 + 1e-11));
    assert_eq!(linear.lower[conductance], f64::NEG_INFINITY);
    assert!((linear.upper[sigma] - libm::log(1.0 / at[sigma])).abs() < 1e-12);
    assert_eq!((linear.rows, linear.readings), (likelihood.residual_count() + 2, likelihood.residual_count()));
    let evaluate = |at: &[f64]| {
        let mut residuals = vec![0.0; linear.readings];
        likelihood.residuals(at, &mut likelihood.workspace(), &mut residuals).unwrap();
        residuals
    };
    for (i, prior) in likelihood.priors().iter().enumerate() {
        let logarithmic = matches!(prior, Distribution::LogNormal { .. } | Distribution::LogUniform { .. });
        let h = 1e-3;
        let moved = |by: f64| {
            let mut at = at.clone();
            at[i] = if logarithmic { at[i] * libm::exp(by) } else { at[i] + by };
            evaluate(&at)
        };
        let (above, below) = (moved(h), moved(-h));
        let largest = (0..linear.readings).fold(0.0, |m: f64, row| m.max(linear.jacobian[row * n + i].abs()));
        for row in 0..linear.readings {
            let difference = (below[row] - above[row]) / (2.0 * h);
            let own = linear.jacobian[row * n + i];
            // The transient's steps are chosen anew: 3e-7 of 300 K over the step and a sigma of 0.1 K.
            assert!((difference - own).abs() < 1e-4 * largest + 0.2, "{i} {row}: {own} {difference}");
        }
    }
    // (ln 0.6 - ln G) / ln 1.3, moved by a step of -1 in it.
    let row = linear.readings;
    let (median, factor) = (libm::log(0.6), libm::log(1.3));
    assert!((linear.residuals[row] - (libm::log(at[conductance]) - median) / factor).abs() < 1e-12);
    assert!((linear.jacobian[row * n + conductance] + 1.0 / factor).abs() < 1e-12);
}

/// Correlated errors of inputs and noise over time: `W` of the derivatives is that of the likelihood itself.
#[test]
fn the_whitening_is_that_of_the_likelihood() {
    let errors = vec![InputError { sigma: Some(0.3), bias: None }];
    let problem = problem(vec![steady(&model()), transient(&model())], errors);
    let (likelihood, at) = fit(&problem);
    let whitening = likelihood.whitening(&at).unwrap();
    // A sensor's bias moves each of its own readings by 1.
    let bias = likelihood.names().iter().position(|name| name.ends_with(".bias")).unwrap();
    let linear = linearise(&likelihood, &at).unwrap();
    let mut column: Vec<f64> = (likelihood.data().iter())
        .map(|datum| f64::from(u8::from(datum.measurement == 1 && datum.sensor == 1)))
        .collect();
    whitening.apply(&mut column).unwrap();
    for (row, value) in column.iter().enumerate() {
        assert!((value - linear.jacobian[row * linear.parameters() + bias]).abs() < 1e-12);
    }
    // Residuals are whitened differences: W (z - f) of twice the difference is twice as much.
    let (found, _) = directions(&problem, &likelihood, &at).unwrap();
    let id = "sensor-bias:TC panel";
    let direction = found.iter().find(|direction| problem.candidates[direction.candidate].id == id).unwrap();
    let mut column: Vec<f64> = likelihood.data().iter().map(|d| f64::from(u8::from(d.sensor == 1))).collect();
    whitening.apply(&mut column).unwrap();
    for (row, value) in column.iter().enumerate() {
        assert!((value - direction.columns[row]).abs() < 1e-10, "{row}");
    }
}

/// The two ways to exact derivatives give the same: adjoints of the steady phases, and sensitivities of a model that
/// holds all effects. Steady solutions close to 1e-9 W, which leaves as much of a derivative.
#[test]
fn adjoints_and_sensitivities_agree() {
    let errors = vec![InputError { sigma: Some(0.3), bias: None }];
    let steady = problem(vec![steady(&model())], errors.clone());
    let mixed = problem(vec![self::steady(&model()), transient(&model())], errors);
    let find = |problem: &Problem| {
        let (likelihood, at) = fit(problem);
        (directions(problem, &likelihood, &at).unwrap().0, likelihood)
    };
    let ((adjoint, likelihood), (extended, _)) = (find(&steady), find(&mixed));
    let rows = likelihood.residual_count();
    let mut compared = 0;
    for direction in adjoint.iter().filter(|direction| !direction.parameters.is_empty()) {
        let same = |other: &&Direction| {
            other.candidate == direction.candidate && other.shape == direction.shape && !other.parameters.is_empty()
        };
        // A hidden node is a path in steady phases alone.
        let Some(other) = extended.iter().find(same) else { continue };
        for (amplitude, position) in direction.parameters.iter().enumerate() {
            let column = direction.column(amplitude);
            let other = other.column(other.parameters.iter().position(|own| own == position).expect("there"));
            let largest = column.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for row in 0..rows {
                let difference = column[row] - other[row];
                let id = &steady.candidates[direction.candidate].id;
                assert!(difference.abs() <= 1e-9 * largest, "{id} row {row}: {} {}", column[row], other[row]);
            }
        }
        compared += 1;
    }
    assert!(compared > 200, "{compared}");
}

/// Over long records effects at nodes are found on fewer rows. They order effects and begin fits: a twentieth of a
/// column's size is near enough; effects on sensors are those of every row.
#[test]
#[ignore = "thorough"]
fn directions_over_long_records_are_near_the_slopes_of_each_effects_likelihood() {
    let problem = problem(vec![long(&model())], vec![]);
    let (likelihood, at) = fit(&problem);
    let (found, _) = directions(&problem, &likelihood, &at).unwrap();
    // Thresholds and the bends of unknown functions are passed a few rows earlier or later: they are farther off.
    let is_even = |direction: &Direction| {
        direction.shape.is_empty() && !problem.candidates[direction.candidate].effect.contains("function")
    };
    let smooth: Vec<&Direction> =
        found.iter().filter(|direction| !direction.parameters.is_empty() && is_even(direction)).collect();
    let (mut on_nodes, mut on_sensors) = (0, 0);
    for direction in smooth.iter().step_by(3) {
        let own = Own::new(&problem, direction.candidate, &likelihood, &at);
        if let Site::Sensors(_) = problem.candidates[direction.candidate].site {
            check(&problem, &own, direction, 1e-3, 1e-2, 0);
            on_sensors += 1;
            continue;
        }
        let (_, values, _) = amplitude_positions(&problem, &problem.candidates[direction.candidate]);
        for (amplitude, &position) in direction.parameters.iter().enumerate() {
            let exact = own.slopes(&values, position);
            let off: f64 = exact.iter().zip(direction.column(amplitude)).map(|(a, b)| (a - b) * (a - b)).sum();
            let off = (off / exact.iter().map(|a| a * a).sum::<f64>()).sqrt();
            assert!(off < 0.05, "{}: {off}", problem.candidates[direction.candidate].id);
            on_nodes += 1;
        }
    }
    assert!(on_nodes > 30 && on_sensors > 0, "{on_nodes} on nodes, {on_sensors} on sensors");
}

/// A fit over a long record begins on fewer rows and ends where the fit on all rows does: its last step gains less than 1e-3 in
/// log posterior density, and so does the other's.
#[test]
fn fits_that_begin_on_fewer_rows_end_where_those_on_all_rows_do() {
    let mut problem = problem(vec![long(&model())], vec![]);
    let (likelihood, _) = fit(&problem);
    let mut residuals = vec![0.0; likelihood.residual_count()];
    likelihood.residuals(&[0.5], &mut likelihood.workspace(), &mut residuals).expect("a solution");
    let sensors = problem.measurements[0].sensors.len();
    for (place, (datum, residual)) in likelihood.data().iter().zip(&residuals).enumerate() {
        // Predictions of another value than the prior's median, with errors that repeat.
        let error = 0.1 * ((place * 7 % 11) as f64 / 5.0 - 1.0);
        let reading = &mut problem.measurements[0].readings[datum.row * sensors + datum.sensor];
        *reading = reading.map(|reading| reading - 0.1 * residual + error);
    }
    let key = StreamKey::new(1, "test", "fewer rows");
    for effect in ["heat-load", "conductive-path", "sensor-gain", "thermal-mass"] {
        let of_effect = |candidate: &Candidate| candidate.effect == effect;
        let set = [problem.candidates.iter().position(of_effect).expect(effect)];
        let fit = |is_near| {
            let begin = Begin { from_prior: 1, scale: 1.0, is_near, ..Begin::default() };
            problem.refit(&set, &begin, &key).expect(effect)
        };
        let (on_fewer_first, on_all) = (fit(false), fit(true));
        let off = on_fewer_first.log_likelihood - on_all.log_likelihood;
        assert!(off.abs() < 5e-3, "{effect}: {off}");
        for (found, exact) in on_fewer_first.amplitudes[0].iter().zip(&on_all.amplitudes[0]) {
            assert!((found.mode - exact.mode).abs() <= 0.1 * exact.sd, "{effect}: {found:?} {exact:?}");
        }
    }
}
