//! Settings and result of a test plan.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::job::propagate::Probability;
use crate::study::profile::Criteria;
use crate::study::resolved::Upstream;

/// Resolved settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The design whose choice is planned.
    pub design: Upstream,
    /// Inputs that the candidate phases share, SI; those that differ are overwritten.
    pub inputs: Vec<f64>,
    /// Inputs before the first phase, SI.
    pub start: Vec<f64>,
    /// Sensors of the design.
    pub sensors: Vec<PlannedSensor>,
    /// What the test is for.
    pub objectives: Vec<String>,
    /// When it has succeeded.
    pub success: Vec<String>,
    /// When a phase is steady.
    pub criteria: Criteria,
    /// Rate of change below which a sensor is steady, K/s.
    pub rate_k_per_s: f64,
    /// Time for readings, s.
    pub hold_s: f64,
    /// Longest time to become steady, s.
    pub longest_s: f64,
    /// Samples behind bands and probabilities, a power of two.
    pub samples: u64,
    /// Samples whose transients are integrated.
    pub transients: u64,
}

/// A sensor as the design has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedSensor {
    /// Name.
    pub name: String,
    /// Index of the measured quantity.
    pub quantity: usize,
    /// Standard deviation of its noise, SI.
    pub sigma: f64,
    /// Standard deviation of a constant error that nobody knows, SI.
    pub bias_sd: Option<f64>,
}

/// An input of the model, all of which a phase sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SetPoint {
    /// Name.
    pub name: String,
    /// Unit as the study writes it.
    pub unit: String,
    /// Value before the first phase, SI.
    pub start: f64,
    /// Whether it differs between phases.
    pub varies: bool,
}

/// A sensor of the test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Instrument {
    /// Name.
    pub name: String,
    /// What it measures.
    pub quantity: String,
    /// SI unit.
    pub unit: String,
    /// Whether it measures an absolute temperature.
    pub is_temperature: bool,
    /// Standard deviation of its noise, SI.
    pub sigma: f64,
    /// Standard deviation of a constant error that nobody knows, SI.
    pub bias_sd: Option<f64>,
}

/// What is predicted of a sensor or a node in a phase, SI: over the priors, without the sensor's own errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Predicted {
    /// At the nominal parameters.
    pub nominal: f64,
    /// Mean.
    pub mean: f64,
    /// Quantiles of 2.5 and 97.5 %.
    pub band: [f64; 2],
}

/// A node with limits in a phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Limited {
    /// Node.
    pub node: String,
    /// Its temperature.
    pub predicted: Predicted,
    /// Yellow limits, K.
    pub yellow: Option<[f64; 2]>,
    /// Red limits, K.
    pub red: Option<[f64; 2]>,
    /// Probability outside the yellow limits.
    pub outside_yellow: Option<Probability>,
    /// Probability outside the red limits.
    pub outside_red: Option<Probability>,
}

/// How long a phase takes to become steady, from the steady state of the one before with a step of its inputs, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Settling {
    /// At the nominal parameters; `null` where it is not steady within the longest time.
    pub nominal_s: Option<f64>,
    /// Quantiles of 5, 50 and 95 % over the samples; `null` where one is not reached within the longest time.
    pub quantiles_s: [Option<f64>; 3],
    /// Samples that are not steady within the longest time, or have no solution.
    pub unsettled: u64,
    /// Time constant of the slowest decay, at the nominal parameters: while the deviation from the final state falls from a
    /// tenth to a hundredth of the step.
    pub time_constant_s: Option<f64>,
}

/// A phase, in its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedPhase {
    /// Name.
    pub name: String,
    /// Value of every input, SI, in the order of `inputs`.
    pub set_points: Vec<f64>,
    /// Expected information of this phase and those before it, nats.
    pub information_nats: f64,
    /// Its standard error.
    pub information_se: f64,
    /// Sensors, in the order of `sensors`.
    pub sensors: Vec<Predicted>,
    /// Nodes with limits.
    pub limits: Vec<Limited>,
    /// Samples without a solution, which count as outside all limits.
    pub failed: u64,
    /// How long it takes to become steady.
    pub settling: Settling,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Output {
    /// The design whose choice this is.
    pub design: String,
    /// Parameters to be learnt.
    pub learn: Vec<String>,
    /// What the test is for, beside that.
    pub objectives: Vec<String>,
    /// When it has succeeded, beside what every test must keep.
    pub success: Vec<String>,
    /// When a phase is steady.
    pub criteria: Criteria,
    /// Rate of change below which a sensor is steady, K/s.
    pub rate_k_per_s: f64,
    /// Time for readings once a phase is steady, s.
    pub hold_s: f64,
    /// Longest time to become steady, s.
    pub longest_s: f64,
    /// Samples behind bands and probabilities, and behind durations.
    pub samples: [u64; 2],
    /// Inputs.
    pub inputs: Vec<SetPoint>,
    /// Sensors.
    pub sensors: Vec<Instrument>,
    /// Phases in order.
    pub phases: Vec<PlannedPhase>,
    /// Duration of all phases with their readings, s: at the nominal parameters, and quantiles of 5, 50 and 95 %; `null` where a
    /// phase is not steady within the longest time.
    pub duration_s: [Option<f64>; 4],
    /// What the reader must know.
    pub findings: Vec<String>,
}
