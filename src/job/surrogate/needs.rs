//! What a surrogate is needed for, and how well it serves: readings where the posterior lies, requirements near their limits,
//! or, where the pass has neither, everywhere within the priors.

use std::sync::Arc;

use super::output::{NeedState, ReadingError};
use super::run::Train;
use crate::expression::Symbol;
use crate::inference::likelihood::{Definition, Likelihood};
use crate::inference::sampler::smc::{SmcSettings, run_island};
use crate::inference::surrogate::choice::Candidate;
use crate::inference::surrogate::{Answers, Emulation, Surrogate};
use crate::inference::target::Target;
use crate::job::JobError;
use crate::math::special::normal_cdf;
use crate::measurement::{Measurement, Rows};
use crate::random::StreamKey;
use crate::study::model::surrogate;
use crate::study::resolve::settings::NOMINAL;
use crate::thermal::{Model, Network, Point, Start, Workspace};

/// Draws of the posterior, and samples of the prior, at which errors are looked at.
const DRAWS: usize = 128;
const SAMPLES: usize = 256;
/// Points among which anchors of the errors are chosen.
pub(super) const TOGETHER: usize = 192;
/// Expected share of samples on the wrong side of a requirement's limit that is small enough.
const WRONG_SIDE: f64 = 0.001;
/// Share of the outputs' spread that is small enough where nothing else is asked.
const EVERYWHERE: f64 = 0.01;

/// A need.
pub(super) struct Need {
    pub state: NeedState,
    pub candidates: Vec<Candidate>,
}

impl Need {
    pub fn is_met(&self) -> bool {
        self.state.error <= self.state.allowed
    }
}

/// What was found of a surrogate.
pub(super) struct Assessed {
    pub needs: Vec<Need>,
    pub readings: Vec<ReadingError>,
    /// Why the posterior could not be had, where there are readings.
    pub no_posterior: Option<String>,
    /// Where errors must go together as they do: phases of the readings at draws of the posterior; empty without any.
    pub posterior: Vec<Point>,
}

/// A surrogate's network, asked for quantities with the slopes by the errors of its outputs.
struct Probe<'a> {
    surrogate: &'a Surrogate,
    network: Network,
    workspace: Workspace,
    /// The surrogate's errors are these parameters. There are no anchors yet, so that each output has one that is its error.
    errors: std::ops::Range<usize>,
    slopes: Vec<f64>,
}

/// Quantities at a point: value, and by output the standard deviation that its error brings.
struct Probed {
    values: Vec<f64>,
    /// `quantities x outputs`.
    slopes: Vec<f64>,
    /// Of each output's error.
    sds: Vec<f64>,
}

impl Probed {
    fn by_output(&self, quantity: usize) -> &[f64] {
        &self.slopes[quantity * self.sds.len()..(quantity + 1) * self.sds.len()]
    }

    /// Standard deviation of a quantity's error.
    fn sd(&self, quantity: usize) -> f64 {
        self.by_output(quantity).iter().map(|slope| slope * slope).sum::<f64>().sqrt()
    }

    /// Weights by which the variances of the outputs' errors make that of a quantity, times `times`.
    fn weights(&self, quantity: usize, times: f64) -> Vec<f64> {
        let weight = |(slope, sd): (&f64, &f64)| if *sd > 0.0 { times * (slope / sd) * (slope / sd) } else { 0.0 };
        self.by_output(quantity).iter().zip(&self.sds).map(weight).collect()
    }
}

impl<'a> Probe<'a> {
    fn new(model: &Model, surrogate: &'a Surrogate, settings: &surrogate::Surrogate) -> Result<Self, JobError> {
        let errors = model.external.as_ref().map_or(0..0, |external| external.errors.clone());
        let symbol = |place: usize| Symbol::Parameter(u32::try_from(place).unwrap_or(u32::MAX));
        let symbols: Vec<Symbol> = settings.rests(errors.start).map(symbol).collect();
        let network = Network::compile(model, &symbols).map_err(|error| JobError::Failed(error.to_string()))?;
        let (workspace, slopes) = (network.workspace(), vec![0.0; network.quantities() * symbols.len()]);
        Ok(Self { surrogate, network, workspace, errors, slopes })
    }

    /// `None` where the surrogate has no answer.
    fn at(&mut self, point: &Point) -> Option<Probed> {
        let mut parameters = point.parameters.clone();
        parameters.truncate(self.errors.start);
        parameters.resize(self.errors.end, 0.0);
        let coordinates = self.surrogate.coordinates(point).ok()?;
        self.network.set_parameters(&mut self.workspace, &parameters);
        self.network.set_inputs(&mut self.workspace, &point.inputs);
        self.network.solve_steady(&mut self.workspace, Start::Default).ok()?;
        self.network.quantity_tangent(&mut self.workspace, &mut self.slopes).ok()?;
        let values = (0..self.network.quantities()).map(|q| self.network.quantity(&self.workspace, q)).collect();
        let sds = self.surrogate.at(&coordinates).iter().map(|expected| expected.sd).collect();
        Some(Probed { values, slopes: self.slopes.clone(), sds })
    }
}

/// Phases of the measurements at draws of the posterior, all phases of a draw before those of the next.
fn together(measurements: &[&Measurement], draws: &[Vec<f64>]) -> Vec<Point> {
    let phases: Vec<&Vec<f64>> = (measurements.iter())
        .filter_map(|measurement| match &measurement.rows {
            Rows::Steady(phases) => Some(phases),
            Rows::Transient { .. } => None,
        })
        .flatten()
        .filter(|phase| phase.ignored.is_none())
        .map(|phase| &phase.inputs)
        .collect();
    let stride = (draws.len() * phases.len()).div_ceil(TOGETHER).max(1);
    let point = |draw: &Vec<f64>, inputs: &Vec<f64>| Point { parameters: draw.clone(), inputs: inputs.clone() };
    let draws = draws.iter().step_by(stride);
    draws.flat_map(|draw| phases.iter().map(move |inputs| point(draw, inputs))).take(TOGETHER).collect()
}

impl Train {
    /// The model with a surrogate in its place.
    fn model_with(&self, surrogate: &Surrogate) -> Model {
        let mut model = self.inputs.model.as_ref().clone();
        if let Some(external) = &mut model.external {
            external.evaluator = Some(Arc::new(Answers::of(surrogate.clone(), self.surrogate.anchors)));
        }
        model
    }

    /// Looks at what the surrogate is needed for; `round` tells the random numbers of rounds apart.
    pub(super) fn assess(
        &self,
        surrogate: &Surrogate,
        emulations: &[Emulation],
        round: u64,
    ) -> Result<Assessed, JobError> {
        let model = self.model_with(surrogate);
        let mut probe = Probe::new(&model, surrogate, &self.surrogate)?;
        let mut assessed =
            Assessed { needs: Vec::new(), readings: Vec::new(), no_posterior: None, posterior: Vec::new() };
        let steady: Vec<&Measurement> =
            self.inputs.measurements.iter().filter(|own| matches!(own.rows, Rows::Steady(_))).collect();
        if !steady.is_empty() {
            match self.posterior(&model, &steady, round) {
                Ok(draws) => {
                    self.needs_of_readings(&mut probe, &steady, &draws, emulations, &mut assessed);
                    assessed.posterior = together(&steady, &draws);
                }
                Err(reason) => assessed.no_posterior = Some(reason),
            }
        }
        self.needs_of_requirements(&mut probe, &mut assessed);
        if assessed.needs.is_empty() {
            self.need_everywhere(&mut probe, emulations, &mut assessed);
        }
        Ok(assessed)
    }

    /// Draws of the posterior of all steady readings under the surrogate, its error included: parameters of the model.
    fn posterior(&self, model: &Model, measurements: &[&Measurement], round: u64) -> Result<Vec<Vec<f64>>, String> {
        let priors = &self.inputs.priors;
        // Anchors are chosen at the end: until then their numbers are without effect.
        let first = model.external.as_ref().map_or(priors.len(), |external| external.errors.start);
        let rests: Vec<usize> = self.surrogate.rests(first).collect();
        let is_inferred = |place: &usize| !priors[*place].is_fixed() && (*place < first || rests.contains(place));
        let parameters: Vec<usize> = (0..priors.len()).filter(is_inferred).collect();
        let likelihood = Likelihood::new(&Definition {
            model,
            priors,
            parameters: &parameters,
            measurements,
            input_errors: &self.inputs.input_errors,
        })
        .map_err(|error| error.to_string())?;
        // They show where the posterior lies, no more.
        let settings = SmcSettings { particles: DRAWS, correlation: 0.3, most_moves: 20, ..SmcSettings::default() };
        let key = StreamKey::new(self.seed, &self.name, "posterior");
        let island = run_island(&likelihood, &settings, &key, round).map_err(|error| error.to_string())?;
        let names = likelihood.names();
        let places: Vec<Option<usize>> =
            names.iter().map(|name| model.parameters.iter().position(|own| own.name == *name)).collect();
        let draw = |row: &[f64]| {
            let mut all = self.nominal.clone();
            for (place, value) in places.iter().zip(row) {
                if let Some(slot) = place.and_then(|place| all.get_mut(place)) {
                    *slot = *value;
                }
            }
            all
        };
        Ok(island.chain.draws.chunks_exact(names.len().max(1)).map(draw).collect())
    }

    fn needs_of_readings(
        &self,
        probe: &mut Probe,
        measurements: &[&Measurement],
        draws: &[Vec<f64>],
        emulations: &[Emulation],
        assessed: &mut Assessed,
    ) {
        for measurement in measurements {
            let Rows::Steady(phases) = &measurement.rows else { continue };
            let phases: Vec<&[f64]> =
                phases.iter().filter(|phase| phase.ignored.is_none()).map(|phase| phase.inputs.as_slice()).collect();
            let noises: Vec<f64> = measurement.sensors.iter().map(|sensor| sensor.total_sd()).collect();
            if phases.is_empty() {
                continue;
            }
            let mut candidates = Vec::new();
            let (mut squares, mut count) = (vec![0.0; noises.len()], 0.0_f64);
            let (mut worst, mut cross_validated) = (0.0, vec![0.0; noises.len()]);
            for (place, draw) in draws.iter().enumerate() {
                let point = Point { parameters: draw.clone(), inputs: phases[place % phases.len()].to_vec() };
                let Some(probed) = probe.at(&point) else { continue };
                let mut most: Option<(usize, f64)> = None;
                for (sensor, noise) in noises.iter().enumerate() {
                    let quantity = measurement.sensors[sensor].quantity;
                    let sd = probed.sd(quantity);
                    squares[sensor] += sd * sd;
                    let of_output = |(weight, own): (f64, &Emulation)| weight * own.left_out.rms * own.left_out.rms;
                    cross_validated[sensor] +=
                        probed.weights(quantity, 1.0).into_iter().zip(emulations).map(of_output).sum::<f64>();
                    if *noise > 0.0 && most.is_none_or(|(_, other)| sd / noise > other) {
                        most = Some((sensor, sd / noise));
                    }
                }
                count += 1.0;
                if let Some((sensor, share)) = most {
                    worst += share * share;
                    let times = 1.0 / (noises[sensor] * noises[sensor]);
                    let weights = probed.weights(measurement.sensors[sensor].quantity, times);
                    candidates.push(Candidate { point, weights });
                }
            }
            let mean = |sum: f64| (sum / count.max(1.0)).sqrt();
            for (place, sensor) in measurement.sensors.iter().enumerate().filter(|(place, _)| noises[*place] > 0.0) {
                assessed.readings.push(ReadingError {
                    measurement: measurement.name.clone(),
                    sensor: sensor.name.clone(),
                    unit: self.inputs.model.quantities[sensor.quantity].unit.clone(),
                    noise: noises[place],
                    error: mean(squares[place]),
                    cross_validated: mean(cross_validated[place]),
                });
            }
            if !candidates.is_empty() {
                let what = format!("readings of `{}` where the posterior lies, in their noise", measurement.name);
                let state = NeedState { what, error: mean(worst), allowed: self.surrogate.share };
                assessed.needs.push(Need { state, candidates });
            }
        }
    }

    fn needs_of_requirements(&self, probe: &mut Probe, assessed: &mut Assessed) {
        let nominal = [(NOMINAL, self.nominal_inputs())];
        let environments: Vec<(&str, Vec<f64>)> = match self.environments.as_slice() {
            [] => nominal.into_iter().collect(),
            some => some.iter().map(|own| (own.name.as_str(), own.inputs.clone())).collect(),
        };
        for (name, inputs) in environments {
            let mut found: Vec<(Vec<Candidate>, f64, f64)> =
                self.requirements.iter().map(|_| (Vec::new(), 0.0, 0.0)).collect();
            for sample in 0..SAMPLES {
                let point = Point { parameters: self.sample(sample).parameters, inputs: inputs.clone() };
                let Some(probed) = probe.at(&point) else { continue };
                for (requirement, (candidates, sum, count)) in self.requirements.iter().zip(&mut found) {
                    let (value, sd) = (probed.values[requirement.quantity], probed.sd(requirement.quantity));
                    let limits = requirement.below.into_iter().chain(requirement.above);
                    let wrong =
                        limits.map(|limit| if sd > 0.0 { normal_cdf(-((limit - value) / sd).abs()) } else { 0.0 });
                    let wrong = wrong.fold(0.0, f64::max);
                    *sum += wrong;
                    *count += 1.0;
                    if wrong > 0.0 {
                        let weights = probed.weights(requirement.quantity, wrong / (sd * sd));
                        candidates.push(Candidate { point: point.clone(), weights });
                    }
                }
            }
            for (requirement, (candidates, sum, count)) in self.requirements.iter().zip(found) {
                if count > 0.0 {
                    let what = format!(
                        "requirement `{}` in `{name}`, expected share of samples on the wrong side of its limit",
                        requirement.name
                    );
                    let state = NeedState { what, error: sum / count, allowed: WRONG_SIDE };
                    assessed.needs.push(Need { state, candidates });
                }
            }
        }
    }

    fn need_everywhere(&self, probe: &mut Probe, emulations: &[Emulation], assessed: &mut Assessed) {
        let (mut candidates, mut sum) = (Vec::new(), 0.0);
        for sample in 0..DRAWS {
            let point = self.sample(sample);
            let Some(probed) = probe.at(&point) else { continue };
            let weight = |own: &Emulation| if own.spread > 0.0 { 1.0 / (own.spread * own.spread) } else { 0.0 };
            let weights: Vec<f64> = emulations.iter().map(weight).collect();
            sum += weights.iter().zip(&probed.sds).map(|(weight, sd)| weight * sd * sd).fold(0.0, f64::max);
            candidates.push(Candidate { point, weights });
        }
        if !candidates.is_empty() {
            let error = (sum / candidates.len() as f64).sqrt();
            let what = "outputs within the priors, in their spread".to_owned();
            assessed.needs.push(Need { state: NeedState { what, error, allowed: EVERYWHERE }, candidates });
        }
    }
}
