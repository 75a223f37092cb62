//! Settings and result of a deterministic correlation.

use serde::{Deserialize, Serialize};

use crate::job::compare::Deviation;
use crate::study::profile::Criteria;

/// How parameters are changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Always that one which alone lowers the misfit most, until the criteria are met.
    OneAtATime,
    /// All together, to the least sum of squares.
    LeastSquares,
}

impl Method {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::OneAtATime => "one parameter at a time",
            Self::LeastSquares => "least squares",
        }
    }
}

/// A parameter that may be changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Free {
    /// Index in the model's list.
    pub index: usize,
    /// Between which values, SI.
    pub range: [f64; 2],
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Positions of the measurements.
    pub data: Vec<usize>,
    /// What may be changed.
    pub parameters: Vec<Free>,
    /// What is to be met.
    pub criteria: Criteria,
    /// How.
    pub method: Method,
}

/// One change on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Change {
    /// The parameter; `None` where all are changed together.
    pub parameter: Option<String>,
    /// Its value after the change, SI.
    pub value: Option<f64>,
    /// Root mean square of the deviations after it, K.
    pub rmse: f64,
    /// Largest magnitude of a deviation after it, K.
    pub max: f64,
    /// Whether the criteria are met after it.
    pub met: bool,
}

/// What became of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Correlated {
    /// Parameter.
    pub name: String,
    /// Unit as written.
    pub unit: String,
    /// Value before, SI.
    pub before: f64,
    /// Value after, SI.
    pub after: f64,
    /// Between which values it could be changed, SI.
    pub range: [f64; 2],
    /// Whether it ended at one of them.
    pub at_bound: bool,
}

/// How a correlation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The criteria were met before any change.
    MetAsDelivered,
    /// The criteria are met.
    Met,
    /// No change of these parameters within their ranges comes closer, and the criteria are not met.
    NotMet,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// How parameters were changed.
    pub method: Method,
    /// What was to be met.
    pub criteria: Criteria,
    /// How it ended.
    pub ended: Ended,
    /// The changes in their order.
    pub changes: Vec<Change>,
    /// The parameters in the order of the settings.
    pub parameters: Vec<Correlated>,
    /// Measured minus predicted before, readings that were fitted, K.
    pub before: Deviation,
    /// The same after.
    pub after: Deviation,
    /// Measured minus predicted of readings held out, before, K.
    pub held_out_before: Deviation,
    /// The same after.
    pub held_out_after: Deviation,
}
