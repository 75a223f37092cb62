//! What is diagnosed.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnosis::FitError;
use crate::diagnosis::places::Places;
use crate::effect::{Candidate, Catalogue, Effect};
use crate::inference::likelihood::{InputError, Likelihood, LikelihoodError};
use crate::inference::prior::joint_prior::{JointPrior, STANDARD};
use crate::measurement::{Measurement, Rows};
use crate::random::Distribution;
use crate::thermal::{Model, Parameter};

/// Name of the parameter that acts on nothing; no study can write it.
const IDLE: &str = "nothing:inferred";

/// A baseline model, its measurements, and the effects that it may be missing.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The baseline model.
    pub model: Arc<Model>,
    /// Priors of its parameters, SI, in the model's order.
    pub priors: Vec<Distribution>,
    /// Positions of the parameters that are inferred; their priors are not fixed.
    pub parameters: Vec<usize>,
    /// The measurements; rows that are held out are in them, marked.
    pub measurements: Vec<Measurement>,
    /// Own errors of the inputs, in the model's order; may be shorter.
    pub input_errors: Vec<InputError>,
    /// The effects.
    pub catalogue: Arc<Catalogue>,
    /// Effects at places, of [`crate::effect::candidates`].
    pub candidates: Arc<Vec<Candidate>>,
    /// Joint priors of some of `parameters`, by their places there; whitened coordinates stand for these in every fit.
    pub joint: Vec<JointPrior>,
    /// Attempted steps after which a measurement's transient is given up, by measurement; empty: never.
    pub most_steps: Vec<u64>,
    /// Times the usual local error that a step of a transient may have: 1 but where effects are only put in order.
    pub tolerance: f64,
    /// Degrees of freedom with which the size of the errors was estimated; `None` where the noise is stated.
    pub noise_freedom: Option<f64>,
    /// Whether the model is taken to be a little wrong everywhere.
    pub is_misspecified: bool,
    /// Independent readings that the fitted ones are worth beside the model error that is allowed for; 0 where none is.
    pub independent_readings: f64,
    /// Names of the effects that are considered; empty: all.
    pub considered: Vec<String>,
    /// Temperature about which each node of the model worked, K, of [`crate::diagnosis::working_temperatures_k`]; may be shorter. Empty in
    /// twins that are not of a study: there laws of temperature refer to 20 degC.
    pub working_temperatures_k: Arc<Vec<Option<f64>>>,
    /// Pairs of nodes between which effects are sought, where the model is too large for all.
    pub places: Places,
    /// Probabilities beforehand that kinds of effects are missing, by their names, where they are not those of all.
    pub missing_probability: BTreeMap<String, f64>,
}

/// A reading that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FittedReading {
    /// Position of the measurement.
    pub measurement: usize,
    /// Row.
    pub row: usize,
    /// Position of the sensor.
    pub sensor: usize,
}

impl Problem {
    /// The readings that are fitted: by measurement, row and sensor.
    pub fn fitted_readings(&self) -> Vec<FittedReading> {
        let mut list = Vec::new();
        for (measurement, own) in self.measurements.iter().enumerate() {
            for row in own.fitted_rows() {
                let sensors = (0..own.sensors.len()).filter(|&sensor| own.reading(row, sensor).is_some());
                list.extend(sensors.map(|sensor| FittedReading { measurement, row, sensor }));
            }
        }
        list
    }

    /// Whether a candidate is an unknown function, whose curve is learnt.
    pub fn is_unknown_function(&self, candidate: usize) -> bool {
        let effect = self.catalogue.get(&self.candidates[candidate].effect);
        effect.is_some_and(Effect::is_unknown_function)
    }

    /// Priors of the baseline model's unknowns, in the order of `parameters`: standard normal ones of whitened coordinates.
    pub(crate) fn priors_of_unknowns(&self) -> Vec<Distribution> {
        let mut priors: Vec<Distribution> = self.parameters.iter().map(|&at| self.priors[at]).collect();
        for &place in self.joint.iter().flat_map(JointPrior::places) {
            priors[place] = STANDARD;
        }
        priors
    }

    /// Whether a measurement is a transient.
    pub fn has_transients(&self) -> bool {
        self.measurements.iter().any(|measurement| matches!(measurement.rows, Rows::Transient { .. }))
    }

    /// A likelihood of the problem's parameters, and perhaps others after them, with the joint priors; `most_steps` are those
    /// of its measurements.
    pub(crate) fn informed(&self, likelihood: Likelihood, most_steps: &[u64]) -> Likelihood {
        likelihood
            .with_joint_priors(self.joint.clone())
            .with_most_steps(most_steps.to_vec())
            .with_tolerance(self.tolerance)
    }

    /// The problem with something to infer. Where nothing is, as in a model whose parameters are all fixed, it gets a
    /// parameter that acts on nothing, with a standard normal prior: residuals, evidence and every effect's direction
    /// stay as they are, and the least squares have a column.
    pub fn with_something_to_infer(mut self) -> Self {
        let baseline = self.hypothesis(&[], 1.0).and_then(|baseline| baseline.likelihood(&self));
        if !matches!(baseline, Err(FitError::Likelihood(LikelihoodError::NoUnknowns))) {
            return self;
        }
        let mut model = (*self.model).clone();
        self.parameters.push(model.parameters.len());
        self.priors.push(Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: None });
        model.parameters.push(Parameter {
            name: IDLE.to_owned(),
            unit: "1".to_owned(),
            nominal: 0.0,
            description: String::new(),
            source: String::new(),
        });
        self.model = Arc::new(model);
        self
    }
}

/// Whether an unknown is the parameter that acts on nothing.
pub(crate) fn is_idle(name: &str) -> bool {
    name == IDLE
}
