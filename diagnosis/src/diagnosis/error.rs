//! Why a diagnosis, or a fit of a set of effects, is not possible.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::effect::apply::ApplyError;
use crate::inference::likelihood::LikelihoodError;
use crate::inference::prior::transform::TransformError;
use crate::inference::sampler::chains::SampleError;
use crate::inference::target::Rejected;
use crate::thermal::NetworkError;

/// Why a model with effects cannot be fitted or screened.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FitError {
    /// An effect that cannot be applied.
    #[error(transparent)]
    Apply(#[from] ApplyError),
    /// A likelihood that cannot be made.
    #[error(transparent)]
    Likelihood(#[from] LikelihoodError),
    /// A network that cannot be solved.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A prior without spread.
    #[error(transparent)]
    Prior(#[from] TransformError),
    /// A fit about which nothing can be linearised.
    #[error("at the fit, {0}")]
    AtFit(Rejected),
    /// A point at which the model has no solution.
    #[error(transparent)]
    Rejected(#[from] Rejected),
    /// A descent that finds nothing.
    #[error(transparent)]
    Descent(#[from] SampleError),
    /// An effect that has no direction about the fit.
    #[error(transparent)]
    NoDirection(#[from] NoDirection),
    /// No descent ended.
    #[error("no descent from any start ended in a fit")]
    NoFit,
    /// The curvature at the fit is not positive definite.
    #[error("the curvature at the fit is not positive definite")]
    NoCurvature,
    /// A row, held out perhaps, in which the fitted model has no solution.
    #[error("no solution in row {row} of `{measurement}`")]
    NoSolution {
        /// Number of the row, from 1.
        row: usize,
        /// Name of the measurement.
        measurement: String,
    },
}

/// Why an effect has no direction about a fit: nothing that its amplitude moves can be linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoDirection {
    /// The parameter is not inferred.
    #[error("it is not inferred here")]
    NotInferred,
    /// The prior is a posterior.
    #[error("its prior is a calibration's posterior, not a written one")]
    PosteriorAsPrior,
    /// The parameter is fixed.
    #[error("it is known")]
    Known,
    /// All slopes are 0.
    #[error("no reading depends on it")]
    NoReading,
    /// The readings of the changed model are others.
    #[error("it changes what is measured")]
    ChangesMeasurement,
    /// A slope is no number.
    #[error("its derivatives are not finite numbers")]
    NotFinite,
    /// An exchange of channels without sensors.
    #[error("it has no sensors")]
    NoSensors,
    /// An exchange of channels of another number than two.
    #[error("it takes two sensors")]
    NotTwoSensors,
    /// An exchange of channels that changes no reading.
    #[error("no measurement has readings of both sensors that differ")]
    NoDifference,
    /// The changed model has no solution.
    #[error("the model does not solve at any of its probes")]
    NoSolution,
    /// A lag without transients.
    #[error("steady phases do not see the lag of a sensor")]
    Lag,
    /// A clock without transients.
    #[error("steady phases do not see the clock of a sensor")]
    Clock,
    /// A heat capacity without transients.
    #[error("steady phases do not see heat capacities")]
    Capacity,
    /// A course in time without transients.
    #[error("steady phases do not see what changes with time")]
    Course,
    /// An effect of steady phases without any.
    #[error("transients do not see it")]
    Transients,
    /// A sensor effect without readings.
    #[error("none of the readings is of such a sensor")]
    NoSuchSensor,
    /// An effect on nothing that was read.
    #[error("none of the readings can see it")]
    NoSuchReading,
    /// An effect that the catalogue lacks.
    #[error("there is no such effect")]
    Unknown,
    /// An effect that no screening reached.
    #[error("it was not screened")]
    NotScreened,
}

/// A set of effects that could not be fitted, as it is stored.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Error)]
#[error("{}: {reason}", effects.join(" + "))]
pub struct Unfitted {
    /// Ids of the effects.
    pub effects: Vec<String>,
    /// Why, in words.
    pub reason: String,
}
