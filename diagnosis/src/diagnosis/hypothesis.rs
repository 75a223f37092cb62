//! The baseline model with a set of effects added, and the measurements as it sees them.

use crate::diagnosis::odds::medium;
use crate::diagnosis::{FitError, Problem};
use crate::effect::apply::LEAST_CAPACITY_J_PER_K;
use crate::effect::parameter::widened;
use crate::effect::{Applied, ApplyError, Candidate, Effect, EffectParameter, Instance, SensorPlace, Site, apply};
use crate::expression::{Dimension, Unit};
use crate::inference::likelihood::{Definition, Likelihood};
use crate::measurement::{Initial, Measurement, Rows, Uncertain};
use crate::random::Distribution;
use crate::thermal::Model;

/// Least standard deviation of the start of a node that was added, where it is inferred, and how far outside the temperatures of
/// the record it may lie, K.
const LEAST_SPREAD_OF_STARTS_K: f64 = 1.0;
/// Share of the standard deviation of a record's temperatures by which the start of a node that was added may be off where all begins
/// at one temperature: what happened before the record is not known.
const SHARE_OF_SPREAD: f64 = 0.25;

/// A model with effects that a problem's model lacks.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Positions of the effects in the problem's list of candidates.
    pub effects: Vec<usize>,
    /// The model with them.
    pub model: Model,
    /// Priors of its parameters, SI.
    pub priors: Vec<Distribution>,
    /// Positions of the inferred parameters: those of the problem, then those of the effects.
    pub parameters: Vec<usize>,
    /// Parameters of each effect: positions in the model.
    pub amplitudes: Vec<std::ops::Range<usize>>,
    /// The measurements with their sensors changed and a start temperature for every added node.
    pub measurements: Vec<Measurement>,
    /// Starts of added nodes that are inferred.
    pub starts: Vec<InferredStart>,
}

/// The start temperature of a node that an effect adds, where it is inferred.
#[derive(Clone, Debug, PartialEq)]
pub struct InferredStart {
    /// Position of the effect in the hypothesis's list.
    pub effect: usize,
    /// Position of the measurement.
    pub measurement: usize,
    /// The node in the model.
    pub node: usize,
    /// Its prior, K.
    pub prior: Distribution,
}

impl Problem {
    /// Adds effects, in the order given. `scale` widens the priors of their amplitudes (1 leaves them).
    ///
    /// # Errors
    /// [`FitError::Apply`] where they do not fit.
    pub fn hypothesis(&self, effects: &[usize], scale: f64) -> Result<Hypothesis, FitError> {
        self.hypothesis_of_widths(effects, &vec![scale; effects.len()])
    }

    /// The same with a width for each effect.
    ///
    /// # Errors
    /// [`FitError::Apply`] where they do not fit.
    pub(crate) fn hypothesis_of_widths(&self, effects: &[usize], widths: &[f64]) -> Result<Hypothesis, FitError> {
        let mut hypothesis = Hypothesis {
            effects: effects.to_vec(),
            model: (*self.model).clone(),
            priors: self.priors.clone(),
            parameters: self.parameters.clone(),
            amplitudes: Vec::new(),
            measurements: self.measurements.clone(),
            starts: Vec::new(),
        };
        for (&effect, &width) in effects.iter().zip(widths) {
            hypothesis.add(self, effect, width)?;
        }
        Ok(hypothesis)
    }
}

impl Hypothesis {
    /// Adds one more effect of the problem.
    fn add(&mut self, problem: &Problem, position: usize, scale: f64) -> Result<(), FitError> {
        let candidate = &problem.candidates[position];
        let misplaced = || ApplyError::Place { effect: candidate.effect.clone() };
        if let Site::Parameter(index) = candidate.site {
            let wide = problem.wider_prior(index, scale).ok_or_else(misplaced)?;
            *self.priors.get_mut(index).ok_or_else(misplaced)? = wide;
            self.amplitudes.push(index..index + 1);
            return Ok(());
        }
        let effect = problem.catalogue.get(&candidate.effect).ok_or_else(misplaced)?;
        let mut parameters = effect.parameters(&self.model, &candidate.bound);
        for parameter in parameters.iter_mut().filter(|parameter| parameter.unit.dimension == heat_capacity()) {
            // A hidden part has some capacity: at exactly 0 the model would not feel it, and evidence would not see the bound.
            if let Distribution::HalfNormal { scale } = parameter.prior {
                let lower = Some(LEAST_CAPACITY_J_PER_K);
                parameter.prior = Distribution::Normal { mean: 0.0, sd: scale, lower, upper: None };
            }
        }
        for parameter in parameters.iter_mut().filter(|parameter| parameter.amplitude && scale != 1.0) {
            parameter.prior = widened(parameter.prior, scale);
        }
        let applied = self.add_as(problem, candidate, effect, &candidate.id, parameters)?;
        let (model, effect) = (&self.model, self.amplitudes.len() - 1);
        for &(node, _) in &applied.nodes {
            // At its host's temperature otherwise, as after long quiet; never so in the midst of a record, nor where so little is
            // known of a test that its noise is not stated.
            let is_unknown = problem.is_misspecified || problem.noise_freedom.is_some();
            let is_free = |measured: &Measurement| is_unknown || measured.follows_gap;
            let measured = self.measurements.iter_mut().enumerate().filter(|(_, measured)| is_free(measured));
            for (measurement, measured) in measured {
                let prior = begin_free(measured, node, model);
                let start = prior.map(|prior| InferredStart { effect, measurement, node, prior });
                self.starts.extend(start);
            }
        }
        Ok(())
    }

    /// Adds an effect at a candidate's place under a name, with parameters of its own.
    pub(crate) fn add_as(
        &mut self,
        problem: &Problem,
        candidate: &Candidate,
        effect: &Effect,
        name: &str,
        parameters: Vec<EffectParameter>,
    ) -> Result<Applied, FitError> {
        let (site, bound) = (self.site(&candidate.site), candidate.bound.clone());
        let reference_k = problem.reference_k(candidate);
        let instance = Instance { name, effect, site, bound, parameters, reference_k, switch: None };
        let applied = apply(&mut self.model, &instance)?;
        let range = applied.first_parameter..applied.first_parameter + instance.parameters.len();
        for (offset, parameter) in instance.parameters.iter().enumerate() {
            self.priors.push(parameter.prior);
            if !parameter.prior.is_fixed() {
                self.parameters.push(range.start + offset);
            }
        }
        self.amplitudes.push(range);
        for measurement in &mut self.measurements {
            for &(node, host) in &applied.nodes {
                measurement.begin_like(node, host);
            }
            for change in &applied.sensors {
                let nominal = change.time().map_or(0.0, |parameter| self.model.parameters[parameter].nominal);
                measurement.change_sensors(change, nominal);
            }
        }
        Ok(applied)
    }

    /// A place as it is now: a sensor that an effect before changed reads another quantity.
    fn site(&self, site: &Site) -> Site {
        let Site::Sensors(sensors) = site else { return site.clone() };
        let now = |place: &SensorPlace| {
            let sensor_now = self.measurements.iter().flat_map(|m| &m.sensors).find(|sensor| sensor.name == place.name);
            SensorPlace { quantity: sensor_now.map_or(place.quantity, |sensor| sensor.quantity), ..place.clone() }
        };
        Site::Sensors(sensors.iter().map(now).collect())
    }

    /// Its likelihood.
    ///
    /// # Errors
    /// [`FitError::Likelihood`].
    pub fn likelihood(&self, problem: &Problem) -> Result<Likelihood, FitError> {
        let measurements: Vec<&Measurement> = self.measurements.iter().collect();
        let likelihood = Likelihood::new(&Definition {
            model: &self.model,
            priors: &self.priors,
            parameters: &self.parameters,
            measurements: &measurements,
            input_errors: &problem.input_errors,
        })?;
        Ok(problem.informed(likelihood, &problem.most_steps))
    }
}

/// Frees the start temperature of a node that was added to a model in a measurement, unless it is that of all: a part that a record finds at its host's
/// temperature is the exception. A part without a source of its own follows what surrounds it, later than that does: it stays
/// between the temperatures that the record shows, and the less its surroundings differ at the start, the nearer to them it is.
/// The prior, K, where it is freed.
fn begin_free(measured: &mut Measurement, node: usize, model: &Model) -> Option<Distribution> {
    let width = measured.sensors.len().max(1);
    let is_temperature = |sensor: usize| {
        let quantity = measured.sensors.get(sensor).and_then(|sensor| model.quantities.get(sensor.quantity));
        quantity.is_some_and(|quantity| quantity.unit == "K")
    };
    let readings = measured.readings.iter().enumerate().filter(|(at, _)| is_temperature(at % width));
    let mut shown: Vec<f64> = readings.filter_map(|(_, reading)| *reading).collect();
    let of_readings = shown.iter().sum::<f64>() / shown.len().max(1) as f64;
    let spread_shown = spread_about(of_readings, &shown);
    let range = |of: &[f64]| [of.iter().copied().fold(f64::INFINITY, f64::min), of.iter().copied().fold(0.0, f64::max)];
    let mut at_start = medium::surroundings_at_start(model, measured);
    let Rows::Transient { initial, inputs, .. } = &mut measured.rows else { return None };
    let Initial::Temperatures { values, shared, balanced } = initial else { return None };
    if shared.contains(&node) || balanced.contains(&node) {
        return None;
    }
    let mean = values.get(node)?.nominal();
    shown.push(mean);
    // Boundaries have no start of their own. Space is no neighbour of what is inside: what no thermometer shows counts as the
    // nearest that one does.
    let [coldest, warmest] = range(&shown);
    at_start.extend(values.iter().map(Uncertain::nominal).filter(|start| *start > 0.0));
    at_start.iter_mut().for_each(|temperature| *temperature = temperature.clamp(coldest, warmest));
    let columns = inputs.columns.iter();
    let of_temperature = columns.filter(|column| model.inputs.get(column.input).is_some_and(medium::is_temperature));
    shown.extend(of_temperature.flat_map(|column| column.values.iter().copied()));
    let [least, most] = range(&shown);
    let [around, before] = [spread_about(mean, &at_start), SHARE_OF_SPREAD * spread_shown];
    let sd = (around * around + before * before).sqrt().min(spread_shown).max(LEAST_SPREAD_OF_STARTS_K);
    let (lower, upper) = (Some((least - LEAST_SPREAD_OF_STARTS_K).max(0.0)), Some(most + LEAST_SPREAD_OF_STARTS_K));
    let prior = Distribution::Normal { mean, sd, lower, upper };
    *values.get_mut(node)? = Uncertain::Inferred(prior);
    Some(prior)
}

/// Root mean square distance of temperatures from one of them, K; 0 without any.
fn spread_about(mean: f64, temperatures: &[f64]) -> f64 {
    let square = temperatures.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>();
    (square / temperatures.len().max(1) as f64).sqrt()
}

/// The dimension of J/K.
fn heat_capacity() -> Dimension {
    Unit::parse("J/K").map_or(Dimension::NONE, |unit| unit.dimension)
}
