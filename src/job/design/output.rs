//! Settings and result of a design of experiments.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::random::Distribution;

/// How the expected information is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// `nested` where its bias and its effective inner samples are good, else `importance`, else `laplace`.
    #[default]
    Automatic,
    /// Nested Monte Carlo: `ln p(z)` over the predictions of other replicates' outer samples, `ln p(z | theta)` by
    /// importance sampling of the nuisance parameters.
    Nested,
    /// Both by importance sampling round Laplace approximations.
    Importance,
    /// Average divergence of Laplace approximations.
    Laplace,
    /// Linear model and normal priors at nominal parameters.
    Linear,
}

impl Estimator {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Nested => "nested",
            Self::Importance => "importance",
            Self::Laplace => "laplace",
            Self::Linear => "linear",
        }
    }

    /// Whether its inner integrals are averages over samples, which tell their own bias.
    pub(super) fn tells_its_bias(self) -> bool {
        matches!(self, Self::Nested | Self::Importance)
    }
}

/// An input that differs between candidates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Varied {
    /// Index in the model's list.
    pub input: usize,
    /// Values of the grid, SI; empty where phases are listed.
    pub values: Vec<f64>,
}

/// A candidate phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Value of every input of the model, SI.
    pub inputs: Vec<f64>,
}

/// A sensor of the experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignSensor {
    /// Name.
    pub name: String,
    /// Index of the measured quantity.
    pub quantity: usize,
    /// Standard deviation of its noise, SI.
    pub sigma: f64,
    /// Prior of a constant error that nobody knows, SI.
    pub bias: Option<Distribution>,
}

/// The own error of an input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErringInput {
    /// Index in the model's list.
    pub input: usize,
    /// Standard deviation of what is independent from phase to phase, SI.
    pub sigma: Option<f64>,
    /// Prior of a constant error, SI.
    pub bias: Option<Distribution>,
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Parameters to learn, positions in the model's list.
    pub learn: Vec<usize>,
    /// Nuisance parameters.
    pub nuisance: Vec<usize>,
    /// Inputs that differ between candidates.
    pub varied: Vec<Varied>,
    /// Candidate phases: of a grid, in the order of `varied` with the last input fastest.
    pub candidates: Vec<Phase>,
    /// Whether the candidates form a grid.
    pub is_grid: bool,
    /// Sensors.
    pub sensors: Vec<DesignSensor>,
    /// Inputs that are not exactly what they are said to be.
    pub input_errors: Vec<ErringInput>,
    /// How information is estimated.
    pub estimator: Estimator,
    /// Further phases that are sought between the values of the grid.
    pub search: u64,
    /// Outer samples, a power of two.
    pub outer: u64,
    /// Inner samples, a power of two of at most half of `outer`.
    pub inner: u64,
    /// Draws of an importance-sampled inner integral, a power of two.
    pub draws: u64,
    /// Largest probability with which a node may lie outside its red limits.
    pub red: Option<f64>,
    /// The same for yellow limits.
    pub yellow: Option<f64>,
    /// How many phases the experiment has.
    pub pick: u64,
    /// How many of the sensors are wanted.
    pub choose_sensors: Option<u64>,
}

/// Probability that limits are violated in a candidate phase.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Violation {
    /// Probability that a node lies outside its red limits; `null` where no node has any.
    pub red: Option<f64>,
    /// The same for yellow limits.
    pub yellow: Option<f64>,
    /// The node that is outside most often.
    pub node: Option<String>,
    /// The limits that are violated more often than is tolerated, which rules the candidate out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_tolerated: Option<Limits>,
}

/// Limits of temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Limits {
    /// Beyond them the hardware may be damaged.
    Red,
    /// Beyond them it may not work as specified.
    Yellow,
}

impl Limits {
    /// Their colour.
    pub fn colour(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Yellow => "yellow",
        }
    }
}

/// A candidate phase and what it would tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Candidate {
    /// The inputs that differ between candidates, SI.
    pub conditions: BTreeMap<String, f64>,
    /// Expected information gain, nats; `null` where the model has no solution in too many samples.
    pub information_nats: Option<f64>,
    /// Standard error.
    pub se: Option<f64>,
    /// Bound of the bias; `null` for `laplace` and `linear`, whose error of approximation nobody knows.
    pub bias_bound: Option<f64>,
    /// Estimate of a linear model with normal priors.
    pub linear_nats: Option<f64>,
    /// By how much it is behind the best, and the standard error of that on common random numbers.
    pub behind_best: Option<[f64; 2]>,
    /// Limits.
    pub violation: Violation,
    /// Whether it keeps the limits and has solutions.
    pub allowed: bool,
    /// Why not.
    pub because: Option<String>,
    /// Share of the samples without a solution.
    pub failed: f64,
    /// Mean effective number of inner samples, of the inner integral that has fewer.
    pub effective_inner: Option<f64>,
    /// Share of the outer samples of which an inner integral has fewer than 10 effective samples.
    pub few_effective: Option<f64>,
    /// Whether the information is within noise of 0; false where the estimate cannot be trusted.
    pub sees_nothing: bool,
    /// Whether the search between the values of the grid found it.
    #[serde(default)]
    pub is_found: bool,
}

/// The best experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Best {
    /// Position of the candidate.
    pub candidate: usize,
    /// Its conditions, SI.
    pub conditions: BTreeMap<String, f64>,
    /// Expected information gain, nats.
    pub information_nats: f64,
    /// Standard error.
    pub se: f64,
    /// Bound of the bias; `null` where it is not known.
    pub bias_bound: Option<f64>,
    /// Other allowed candidates that are not distinguished from it: within two standard errors of the difference and
    /// the bias.
    pub rivals: Vec<usize>,
}

/// A step of a greedy choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pick {
    /// Position of the candidate, or of the sensor, that is added.
    pub position: usize,
    /// Information of all chosen so far, nats.
    pub information_nats: f64,
    /// Standard error.
    pub se: f64,
    /// Bound of the bias; `null` where it is not known.
    pub bias_bound: Option<f64>,
}

/// The estimate from the first of the outer samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Partial {
    /// Outer samples.
    pub samples: u64,
    /// Estimate, nats.
    pub information_nats: f64,
    /// Standard error; `null` of one replicate.
    pub se: Option<f64>,
}

/// What a parameter does to a sensor at the best candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Observed {
    /// Parameter.
    pub parameter: String,
    /// Whether it is to be learnt.
    pub learn: bool,
    /// Change of each sensor's reading for one prior standard deviation, SI.
    pub changes: Vec<f64>,
}

/// Two sensors that tell the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Redundant {
    /// The sensors.
    pub sensors: [String; 2],
    /// Their correlation over the prior.
    pub correlation: f64,
}

/// A sensor as it was used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UsedSensor {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Standard deviation of its noise, SI.
    pub sigma: f64,
}

/// An input that differs between candidates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Axis {
    /// Name.
    pub input: String,
    /// Unit as the study writes it.
    pub unit: String,
    /// Values of the grid, SI.
    pub values: Vec<f64>,
}

fn yes() -> bool {
    true
}

/// Result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Output {
    /// The estimator of the numbers.
    pub estimator: String,
    /// Why this one, where the study left the choice; empty where it named one.
    #[serde(default)]
    pub because: String,
    /// Whether the estimates can be relied on by their own diagnostics; without that no candidate is the best. An approximation
    /// that the study names has no diagnostics.
    #[serde(default = "yes")]
    pub is_trusted: bool,
    /// Parameters to learn.
    pub learn: Vec<String>,
    /// Nuisance parameters and unknown errors of sensors.
    pub nuisance: Vec<String>,
    /// Sensors.
    pub sensors: Vec<UsedSensor>,
    /// Inputs that differ between candidates.
    pub axes: Vec<Axis>,
    /// Whether the candidates form a grid, the last input fastest; what a search found comes after it.
    pub is_grid: bool,
    /// Outer samples, inner samples, draws of inner integrals by importance sampling.
    pub samples: [u64; 3],
    /// Largest tolerated probabilities outside red and yellow limits.
    pub limits: [Option<f64>; 2],
    /// Candidates.
    pub candidates: Vec<Candidate>,
    /// The best of those that are allowed; `null` where none is, or where the estimates cannot be trusted.
    pub best: Option<Best>,
    /// Greedy choice of several phases.
    pub picks: Vec<Pick>,
    /// Whether the greedy choice has a guarantee, in words; empty without one to make.
    pub guarantee: String,
    /// Greedy choice of sensors at the best candidate.
    pub sensor_picks: Vec<Pick>,
    /// Estimates of the best candidate from 1, 2, 4, ... replicates.
    pub convergence: Vec<Partial>,
    /// Parameters by sensors at the best candidate.
    pub observability: Vec<Observed>,
    /// Correlations of the sensors' noise-free readings over the prior at the best candidate; `null` for a sensor that does
    /// not move.
    pub correlations: Vec<Vec<Option<f64>>>,
    /// Pairs of sensors that tell the same.
    pub redundant: Vec<Redundant>,
    /// What the reader must know.
    pub findings: Vec<String>,
    /// Model solutions.
    pub solutions: u64,
}
