//! What a surrogate is: how well it predicts runs, how well it must, and the runs behind it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::inference::surrogate::{Emulation, Run, Space};

/// How well an output is predicted, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutputError {
    /// The output.
    pub output: String,
    /// SI unit.
    pub unit: String,
    /// Standard deviation of the output over the runs within the priors.
    pub spread: f64,
    /// Cross-validated error: root mean square over runs that were left out one by one, hyperparameters fitted in ten folds.
    pub error: f64,
    /// The error as a share of the spread; `null` of a constant.
    pub share: Option<f64>,
    /// Largest error of a run that was left out.
    pub worst: f64,
    /// Cross-validated error of the runs of the rounds alone, which lie where the surrogate is needed; `null` without any.
    pub error_where_needed: Option<f64>,
    /// Factor by which the process' own standard deviation is widened, as runs left out asked for it.
    pub widened: f64,
    /// Points at which the error is a parameter of its own.
    pub anchors: u64,
    /// Share of the error's variance that these leave, where they were chosen: it counts as the same number of standard deviations
    /// at all points. `null` of a constant.
    pub beside_anchors: Option<f64>,
}

/// How well a sensor's readings are predicted where the posterior lies, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReadingError {
    /// The measurement.
    pub measurement: String,
    /// The sensor.
    pub sensor: String,
    /// SI unit.
    pub unit: String,
    /// Standard deviation of the readings' noise.
    pub noise: f64,
    /// Standard deviation of the surrogate's error, root mean square over the posterior's draws and the phases.
    pub error: f64,
    /// Cross-validated error over all runs.
    pub cross_validated: f64,
}

/// How far a need is met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NeedState {
    /// What the surrogate is needed for, in words.
    pub what: String,
    /// Its error: of readings in their noise, of a requirement the expected share of samples on the wrong side of its limit,
    /// elsewhere in the outputs' spread.
    pub error: f64,
    /// The error that is small enough.
    pub allowed: f64,
}

/// The state after the first runs, and after each round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Round {
    /// True runs so far.
    pub runs: u64,
    /// The needs.
    pub needs: Vec<NeedState>,
}

/// What answers in the model's place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// The coordinates.
    pub space: Space,
    /// The runs.
    pub runs: Vec<Run>,
    /// What was fitted to them, by output.
    pub emulations: Vec<Emulation>,
}

/// A surrogate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Output {
    /// The model that it stands for.
    pub model: String,
    /// True runs that gave outputs.
    pub runs: u64,
    /// How many of these lay within the priors, not where they were needed.
    pub first_runs: u64,
    /// True runs that failed.
    pub failed: u64,
    /// Why the first of these failed.
    pub failure: Option<String>,
    /// Parameters and inputs over which it was trained.
    pub coordinates: Vec<String>,
    /// How well each output is predicted.
    pub outputs: Vec<OutputError>,
    /// How well each sensor's readings are predicted where the posterior lies.
    pub readings: Vec<ReadingError>,
    /// The state after the first runs, and after each round.
    pub rounds: Vec<Round>,
    /// What must be known before results are relied on, a sentence each; empty where nothing is.
    pub findings: Vec<String>,
    /// Runs and processes.
    #[schemars(with = "serde_json::Value")]
    pub trained: Trained,
}
