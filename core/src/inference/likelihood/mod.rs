//! The likelihood of a network's parameters, and of what is inferred of the data, given measurements.
//!
//! `z = f(theta) + bias + noise`; residuals `r = W (z - f - bias)` with `W' W` the inverse covariance of the noise:
//! by sensor over time in a transient (`noise`), by phase in steady data, `diag(sigma^2) + F S F'` where inputs have
//! known errors of their own, `F` the derivatives of the readings with respect to the inputs at nominal parameters.
//! Rows that are held out or ignored, and missing readings, take no part. An evaluation depends on its arguments only.
//!
//! Where parameters have a joint prior ([`Likelihood::with_joint_priors`]), whitened coordinates with standard normal priors
//! stand in their place among the unknowns, under their names, in everything that is asked of the likelihood.

mod build;
mod course;
pub mod fewer_rows;
mod input_error;
pub mod noise;
pub mod rows;
mod steady;
mod transient;
mod whitening;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::inference::prior::joint_prior::{JointPrior, STANDARD, pull_back, unknowns_at};
use crate::inference::target::{LeastSquares, Rejected, Target};
use crate::measurement::Measurement;
use crate::measurement::timing::Timing;
use crate::measurement::unknown::{Unknowns, Value};
use crate::random::Distribution;
use crate::thermal::{self, Network, NetworkError, Transient};
pub(super) use build::is_used;
use input_error::InputErrors;
use noise::Noise;
use steady::{SteadyLanes, SteadyPart};
use transient::TransientPart;

pub use course::{Course, CourseSensor};
pub use fewer_rows::FewerRows;
pub use input_error::covariance_by_inputs;
pub use noise::Filter;
pub use whitening::Whitening;

/// Readings from which on the courses of several transients are found side by side: fewer take less time than handing them over.
const LEAST_SIDE_BY_SIDE: usize = 500;

/// Half of ln(2 pi).
pub const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;

/// The own error of an input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct InputError {
    /// Standard deviation, SI, independent from phase to phase; enters steady data only.
    pub sigma: Option<f64>,
    /// Prior of a constant error that is inferred, SI.
    pub bias: Option<Distribution>,
}

/// What a likelihood is made of.
#[derive(Clone, Copy, Debug)]
pub struct Definition<'a> {
    /// The model.
    pub model: &'a thermal::Model,
    /// Priors of the model's parameters, SI; fixed ones have their value, others that are not chosen their nominal one.
    pub priors: &'a [Distribution],
    /// Positions of the chosen parameters; their priors are not fixed.
    pub parameters: &'a [usize],
    /// The measurements.
    pub measurements: &'a [&'a Measurement],
    /// Own errors of the inputs, in the model's order; may be shorter.
    pub input_errors: &'a [InputError],
}

/// Why there is no likelihood.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LikelihoodError {
    /// A network that cannot be compiled.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A sensor without noise.
    #[error(
        "sensor `{sensor}` of `{measurement}` has no `sigma`: a calibration needs its noise, as a value or with a prior"
    )]
    NoSigma {
        /// The measurement.
        measurement: String,
        /// The sensor.
        sensor: String,
    },
    /// A standard deviation that is not above 0.
    #[error("the sigma of sensor `{sensor}` of `{measurement}` is {value}, expected a value above 0")]
    Sigma {
        /// The measurement.
        measurement: String,
        /// The sensor.
        sensor: String,
        /// The value, SI.
        value: f64,
    },
    /// Nothing to fit.
    #[error("there is no reading to fit: all rows are held out, ignored or empty")]
    NoData,
    /// Nothing to infer.
    #[error("there is nothing to infer: every parameter is fixed")]
    NoUnknowns,
    /// Two unknowns of one name.
    #[error("two unknowns are called `{name}`: rename the measurement or the sensor")]
    Twice {
        /// The name.
        name: String,
    },
    /// Errors of the inputs that no covariance allows.
    #[error("the covariance of phase `{phase}` of `{measurement}` is not positive definite")]
    Covariance {
        /// The measurement.
        measurement: String,
        /// The phase.
        phase: String,
    },
}

/// Where a whitened residual comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datum {
    /// Position of the measurement in the definition's list.
    pub measurement: usize,
    /// Row.
    pub row: usize,
    /// Position of the sensor.
    pub sensor: usize,
}

/// A sensor as the likelihood sees it.
#[derive(Clone, Debug)]
struct SensorPart {
    quantity: usize,
    noise: Noise,
    bias: Option<Value>,
    lag_s: Option<Value>,
    /// Their sum counts.
    behind_s: Vec<Value>,
}

impl SensorPart {
    /// When it shows what happens.
    fn timing(&self, unknowns: &[f64]) -> Timing {
        let lag_s = self.lag_s.map_or(0.0, |lag| lag.at(unknowns));
        Timing { lag_s, behind_s: self.behind_s.iter().map(|behind| behind.at(unknowns)).sum() }
    }
}

/// A steady phase at given unknowns.
#[derive(Clone, Debug)]
pub struct SteadyState {
    /// Position of its first residual; the others follow.
    pub first: usize,
    /// Inputs, their constant errors included, SI.
    pub inputs: Vec<f64>,
    /// Temperatures of all nodes, K.
    pub temperatures: Vec<f64>,
    /// Adjoint of each reading's quantity, `readings x nodes` ([`Network::quantity_adjoint`]).
    pub adjoint: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Part {
    Steady(SteadyPart),
    Transient(TransientPart),
}

/// The likelihood of a model's parameters given measurements.
#[derive(Clone, Debug)]
pub struct Likelihood {
    unknowns: Unknowns,
    network: Network,
    /// All parameters where nothing is inferred.
    base: Vec<f64>,
    /// Position in the model of each chosen parameter; these are the first unknowns.
    parameters: Vec<usize>,
    /// Inputs with an inferred constant error, and the place of that unknown.
    biases: Vec<(usize, usize)>,
    /// Unknown of each differentiated symbol.
    columns: Vec<usize>,
    /// A measurement each.
    parts: Vec<Part>,
    data: Vec<Datum>,
    known_errors: Option<Arc<InputErrors>>,
    /// Joint priors; none: coordinates are the unknowns.
    joint: Vec<JointPrior>,
    /// Attempted steps after which the transient of a measurement is given up; may be shorter, or empty: never.
    most_steps: Vec<u64>,
    /// Times the usual local error that a step of a transient may have.
    tolerance: f64,
}

/// What an evaluation leaves in the memory beside residuals and scales.
enum Wanted<'a> {
    Values,
    /// Derivatives of the residuals and of the scales.
    Jacobian,
    /// Adds the derivatives of the log likelihood; costs one adjoint solve a phase.
    Gradient(&'a mut [f64]),
}

/// Memory of one chain.
#[derive(Clone, Debug)]
pub struct Memory {
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    start: Vec<f64>,
    /// Where there are steady phases.
    lanes: Option<Box<SteadyLanes>>,
    /// A factor, then a column.
    factor: Vec<f64>,
    residuals: Vec<f64>,
    jacobian: Vec<f64>,
    log_scales: Vec<f64>,
    scale_gradient: Vec<f64>,
    /// Of transients whose derivatives are found on fewer rows: the unknowns of the last course over all rows, and its quantities, `rows
    /// x quantities`. A descent asks for the value at a point and then for its slopes.
    courses: BTreeMap<usize, (Vec<f64>, Vec<f64>)>,
}

impl Likelihood {
    /// Prepares a likelihood; the references of the steady phases are solved at nominal parameters.
    ///
    /// # Errors
    /// [`LikelihoodError`] names what is missing.
    pub fn new(definition: &Definition<'_>) -> Result<Self, LikelihoodError> {
        build::build(definition)
    }

    /// The same with joint priors of some of the chosen parameters, which share none.
    pub fn with_joint_priors(mut self, joint: Vec<JointPrior>) -> Self {
        for &place in joint.iter().flat_map(JointPrior::places) {
            self.unknowns.priors[place] = STANDARD;
        }
        self.joint = joint;
        self
    }

    /// The same with a number of attempted steps, by measurement, after which a transient is given up: the point is then
    /// rejected ([`Rejected::is_given_up`]).
    pub fn with_most_steps(mut self, most_steps: Vec<u64>) -> Self {
        self.most_steps = most_steps;
        self
    }

    /// The same with transients whose steps may have so many times the usual local error.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// The unknowns at coordinates.
    fn at<'c>(&self, coordinates: &'c [f64]) -> Cow<'c, [f64]> {
        if self.joint.is_empty() {
            return Cow::Borrowed(coordinates);
        }
        Cow::Owned(unknowns_at(&self.joint, coordinates).0)
    }

    /// The same with derivatives of transients from fewer rows, by measurement, `None` where they are found on all: residuals are
    /// as before, the Jacobian nearly so.
    pub fn with_slopes_on(mut self, fewer: &[Option<FewerRows>]) -> Self {
        for part in &mut self.parts {
            if let Part::Transient(part) = part {
                part.find_slopes_on(fewer);
            }
        }
        self
    }

    /// Attempted steps of each measurement's transient, 0 for steady phases.
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    pub fn transient_steps(&self, unknowns: &[f64]) -> Result<Vec<u64>, Rejected> {
        let unknowns = self.at(unknowns);
        let full = self.full_of(&unknowns);
        let steps = self.parts.iter().map(|part| match part {
            Part::Steady(_) => Ok(0),
            Part::Transient(part) => part.attempted_steps(self, &unknowns, &full),
        });
        steps.collect()
    }

    /// The unknowns with their priors and SI units: chosen parameters, then what is inferred of the data.
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// When a sensor of a measurement shows what happens, at given unknowns.
    pub fn timing(&self, measurement: usize, sensor: usize, unknowns: &[f64]) -> Timing {
        let sensors = match &self.parts[measurement] {
            Part::Steady(part) => part.sensors(),
            Part::Transient(part) => part.sensors(),
        };
        sensors[sensor].timing(&self.at(unknowns))
    }

    /// Number of chosen parameters of the model, which are the first unknowns.
    pub fn model_parameters(&self) -> usize {
        self.parameters.len()
    }

    /// Where each residual comes from, in their order.
    pub fn data(&self) -> &[Datum] {
        &self.data
    }

    /// All parameters of the model, SI, at given unknowns.
    pub fn full_parameters(&self, unknowns: &[f64]) -> Vec<f64> {
        self.full_of(&self.at(unknowns))
    }

    fn full_of(&self, unknowns: &[f64]) -> Vec<f64> {
        let mut full = self.base.clone();
        for (&position, value) in self.parameters.iter().zip(unknowns) {
            full[position] = *value;
        }
        full
    }

    /// Covariance that the inputs' known errors give to the readings of all sensors of a steady measurement (its position in
    /// the definition's list) at given inputs, at nominal parameters: `sensors x sensors`, SI. `None` without such errors,
    /// for a transient, and where the network has no solution.
    pub fn input_covariance(&self, measurement: usize, inputs: &[f64]) -> Option<Vec<f64>> {
        let (errors, Part::Steady(part)) = (self.known_errors.as_ref()?, self.parts.get(measurement)?) else {
            return None;
        };
        errors.covariance(&mut errors.workspace(&self.base), inputs, part.sensors())
    }

    /// Solves the steady phases anew at given unknowns; later evaluations start from there, by first-order prediction.
    /// A phase that does not solve there starts from the boundaries' mean.
    pub fn set_reference(&mut self, unknowns: &[f64]) {
        let unknowns = self.at(unknowns).into_owned();
        let full = self.full_of(&unknowns);
        let mut shifts = vec![0.0; self.network.nominal_inputs().len()];
        for &(input, place) in &self.biases {
            shifts[input] = unknowns[place];
        }
        let at: Vec<f64> = self.columns.iter().map(|&unknown| unknowns[unknown]).collect();
        for part in &mut self.parts {
            if let Part::Steady(part) = part {
                part.set_reference(&self.network, &full, &shifts, &at);
            }
        }
    }

    /// Solves the steady phases at given unknowns.
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    pub fn steady_states(&self, unknowns: &[f64]) -> Result<Vec<SteadyState>, Rejected> {
        let mut memory = self.workspace();
        let unknowns = &*self.at(unknowns);
        let full = self.full_of(unknowns);
        let mut network = self.network.workspace();
        self.network.set_parameters(&mut network, &full);
        self.network.set_time(&mut network, 0.0);
        let mut states = Vec::new();
        for part in &self.parts {
            if let Part::Steady(part) = part {
                part.states(self, unknowns, &mut network, &mut memory, &mut states)?;
            }
        }
        Ok(states)
    }

    /// Writes the log density of each reading given those before it, in the order of [`Likelihood::data`], and gives the
    /// sum of squares of the whitened residuals.
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    pub fn pointwise(&self, unknowns: &[f64], memory: &mut Memory, out: &mut [f64]) -> Result<f64, Rejected> {
        self.evaluate(unknowns, memory, &mut Wanted::Values)?;
        for (out, (r, scale)) in out.iter_mut().zip(memory.residuals.iter().zip(&memory.log_scales)) {
            *out = scale - HALF_LN_TAU - 0.5 * r * r;
        }
        Ok(memory.residuals.iter().map(|r| r * r).sum())
    }

    /// Fills the memory's residuals and scales, and what is wanted besides; returns the offset.
    fn evaluate(&self, coordinates: &[f64], memory: &mut Memory, wanted: &mut Wanted<'_>) -> Result<f64, Rejected> {
        if self.joint.is_empty() {
            return self.evaluate_at(coordinates, memory, wanted);
        }
        let (unknowns, slopes) = unknowns_at(&self.joint, coordinates);
        let offset = self.evaluate_at(&unknowns, memory, wanted)?;
        match wanted {
            Wanted::Values => {}
            Wanted::Jacobian => {
                for row in memory.jacobian.chunks_exact_mut(unknowns.len()) {
                    pull_back(&self.joint, &slopes, row);
                }
                pull_back(&self.joint, &slopes, &mut memory.scale_gradient);
            }
            Wanted::Gradient(gradient) => pull_back(&self.joint, &slopes, gradient),
        }
        Ok(offset)
    }

    /// The courses of several long transients, in their order; none where they are short or there is one.
    fn courses_side_by_side(
        &self,
        unknowns: &[f64],
        memory: &mut Memory,
        slopes: bool,
    ) -> Vec<Result<Transient, Rejected>> {
        let transients = self.parts.iter().filter_map(|part| match part {
            Part::Transient(part) => Some(part),
            Part::Steady(_) => None,
        });
        if transients.clone().count() < 2 || self.data.len() < LEAST_SIDE_BY_SIDE {
            return Vec::new();
        }
        let transients: Vec<_> = transients.map(|part| (part, part.kept(unknowns, memory))).collect();
        let parameters = &memory.parameters;
        let course = |(part, kept): (&TransientPart, _)| part.course(self, unknowns, parameters, kept, slopes);
        transients.into_par_iter().map(course).collect()
    }

    /// The same at given unknowns, derivatives by these.
    fn evaluate_at(&self, unknowns: &[f64], memory: &mut Memory, wanted: &mut Wanted<'_>) -> Result<f64, Rejected> {
        for (&position, value) in self.parameters.iter().zip(unknowns) {
            memory.parameters[position] = *value;
        }
        if !matches!(wanted, Wanted::Values) {
            memory.jacobian.fill(0.0);
            memory.scale_gradient.fill(0.0);
        }
        let slopes = !matches!(wanted, Wanted::Values);
        let mut found = self.courses_side_by_side(unknowns, memory, slopes).into_iter();
        for part in &self.parts {
            match part {
                Part::Steady(part) => part.evaluate(self, unknowns, memory, wanted)?,
                Part::Transient(part) => {
                    let course = found.next().unwrap_or_else(|| {
                        let kept = part.kept(unknowns, memory);
                        part.course(self, unknowns, &memory.parameters, kept, slopes)
                    });
                    part.evaluate(self, unknowns, memory, course?, slopes)?;
                    if let Wanted::Gradient(gradient) = wanted {
                        let n = gradient.len();
                        for at in part.residuals() {
                            let row = &memory.jacobian[at * n..(at + 1) * n];
                            for (g, slope) in gradient.iter_mut().zip(row) {
                                *g -= memory.residuals[at] * slope;
                            }
                        }
                    }
                }
            }
        }
        if let Wanted::Gradient(gradient) = wanted {
            for (g, slope) in gradient.iter_mut().zip(&memory.scale_gradient) {
                *g += slope;
            }
        }
        let scales: f64 = memory.log_scales.iter().sum();
        Ok(scales - HALF_LN_TAU * self.data.len() as f64)
    }
}

impl Target for Likelihood {
    type Workspace = Memory;

    fn names(&self) -> &[String] {
        &self.unknowns.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.unknowns.priors
    }

    fn workspace(&self) -> Memory {
        let (rows, n) = (self.data.len(), self.unknowns.len());
        let widest = self.parts.iter().map(|part| match part {
            Part::Steady(part) => part.widest(),
            Part::Transient(_) => 0,
        });
        let widest = widest.max().unwrap_or(0);
        Memory {
            parameters: self.base.clone(),
            inputs: self.network.nominal_inputs().to_vec(),
            start: vec![0.0; self.network.nodes()],
            lanes: (self.parts.iter().any(|part| matches!(part, Part::Steady(_))))
                .then(|| Box::new(SteadyLanes::new(&self.network))),
            factor: vec![0.0; widest * (widest + 1)],
            residuals: vec![0.0; rows],
            jacobian: vec![0.0; rows * n],
            log_scales: vec![0.0; rows],
            scale_gradient: vec![0.0; n],
            courses: BTreeMap::new(),
        }
    }

    fn log_likelihood(&self, parameters: &[f64], memory: &mut Memory) -> Result<f64, Rejected> {
        let offset = self.evaluate(parameters, memory, &mut Wanted::Values)?;
        Ok(offset - 0.5 * memory.residuals.iter().map(|r| r * r).sum::<f64>())
    }

    fn log_likelihood_gradient(
        &self,
        parameters: &[f64],
        memory: &mut Memory,
        gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        gradient.fill(0.0);
        let offset = self.evaluate(parameters, memory, &mut Wanted::Gradient(gradient))?;
        Ok(offset - 0.5 * memory.residuals.iter().map(|r| r * r).sum::<f64>())
    }
}

impl LeastSquares for Likelihood {
    fn residual_count(&self) -> usize {
        self.data.len()
    }

    fn residuals(&self, parameters: &[f64], memory: &mut Memory, residuals: &mut [f64]) -> Result<f64, Rejected> {
        let offset = self.evaluate(parameters, memory, &mut Wanted::Values)?;
        residuals.copy_from_slice(&memory.residuals);
        Ok(offset)
    }

    fn jacobian(
        &self,
        parameters: &[f64],
        memory: &mut Memory,
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        let offset = self.evaluate(parameters, memory, &mut Wanted::Jacobian)?;
        residuals.copy_from_slice(&memory.residuals);
        jacobian.copy_from_slice(&memory.jacobian);
        offset_gradient.copy_from_slice(&memory.scale_gradient);
        Ok(offset)
    }
}
