//! Settings and result of a comparison.

use super::readings::Readings;
use crate::study::profile::Criteria;
use serde::{Deserialize, Serialize};

/// A number's summary of measured minus predicted over some readings, in the sensor's SI unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Deviation {
    /// Number of readings.
    pub count: u64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation about the mean (n - 1).
    pub sd: f64,
    /// Root mean square.
    pub rmse: f64,
    /// Largest magnitude.
    pub max: f64,
    /// Share of readings within the profile's limit for one sensor.
    pub within_limit: f64,
}

/// One criterion's outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Verdict {
    /// What was asked, in words.
    pub criterion: String,
    /// The value.
    pub value: f64,
    /// The limit.
    pub limit: f64,
    /// Whether it is kept.
    pub kept: bool,
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Positions of the measurements in the pass's list.
    pub data: Vec<usize>,
    /// The profile.
    pub criteria: Criteria,
    /// Name of the parameters' state as delivered: `nominal`.
    pub from: String,
    /// The calibration whose tuned state stands beside it.
    pub calibration: Option<String>,
}

/// A sensor's statistics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SensorSummary {
    /// Measurement.
    pub measurement: String,
    /// Sensor.
    pub sensor: String,
    /// SI unit.
    pub unit: String,
    /// Noise's standard deviation where known.
    pub sigma: Option<f64>,
    /// Readings that a fit may use.
    pub train: Deviation,
    /// Readings held out.
    pub held_out: Deviation,
    /// RMSE over all readings that the noise alone would give with 95 % probability, where sigma is known: lower and
    /// upper end.
    pub noise_rmse: Option<[f64; 2]>,
    /// Number of missing readings.
    pub missing: u64,
    /// The tuned state.
    #[serde(default)]
    pub tuned: Option<TunedSensor>,
}

/// What tuning made of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct TunedSensor {
    /// Readings that the fit used.
    pub train: Deviation,
    /// Readings held out.
    pub held_out: Deviation,
    /// Standard deviation of the noise, known or as tuned, SI.
    pub sigma: Option<f64>,
    /// RMSE that this noise alone would give over all readings with 95 % probability, its correlation in time allowed for.
    pub noise_rmse: Option<[f64; 2]>,
}

/// The tuned state as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct TunedState {
    /// The calibration.
    pub job: String,
    /// Parameters of the model, SI: name, unit as written, value.
    pub parameters: Vec<(String, String, f64)>,
    /// All readings that the fit used.
    pub train: Deviation,
    /// All readings held out.
    pub held_out: Deviation,
}

impl SensorSummary {
    /// RMSE that the noise alone would give with 95 % probability to as many readings as some deviations have.
    pub fn noise_rmse_of(&self, deviation: &Deviation) -> Option<[f64; 2]> {
        self.noise_rmse?;
        Some(super::deviation::noise_rmse(self.sigma?, deviation.count))
    }
}

/// A phase's statistics over all sensors in kelvin (where there are none, those in the unit of the first).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PhaseSummary {
    /// Measurement.
    pub measurement: String,
    /// Phase; for a transient a stretch of time, such as `0 to 120 s`.
    pub phase: String,
    /// Held out.
    pub held_out: bool,
    /// Statistics.
    pub deviation: Deviation,
    /// Sensor with the largest deviation.
    pub worst_sensor: String,
    /// That deviation, SI.
    pub worst: f64,
}

/// Heat balance of the model in a phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct HeatBalance {
    /// Measurement.
    pub measurement: String,
    /// Phase, or stretch of time.
    pub phase: String,
    /// Heat of loads, heaters and electrical power of coolers, W (mean over a stretch).
    pub sources_w: f64,
    /// Heat into boundaries by node name, W.
    pub into_boundaries_w: Vec<(String, f64)>,
    /// Heat stored, W.
    pub stored_w: f64,
    /// Sources minus boundaries minus stored, W.
    pub imbalance_w: f64,
}

/// Trend of a sensor's residual against an input or time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Trend {
    /// Measurement.
    pub measurement: String,
    /// Sensor.
    pub sensor: String,
    /// `time` or the name of an input.
    pub against: String,
    /// Unit of the slope's denominator, SI.
    pub unit: String,
    /// Slope, SI.
    pub slope: f64,
    /// Standard error (residuals' correlation in time allowed for).
    pub slope_error: f64,
    /// Linear correlation.
    pub correlation: f64,
    /// Change of the residual over the range of the input, in the sensor's SI unit.
    pub change: f64,
}

/// Steadiness of a phase where a time series was given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StabilisationCheck {
    /// Measurement.
    pub measurement: String,
    /// Phase.
    pub phase: String,
    /// Sensor with the fastest drift.
    pub sensor: String,
    /// Its drift, K/s.
    pub drift_k_per_s: f64,
    /// Standard error of the drift, K/s.
    pub drift_error_k_per_s: f64,
    /// Heat hidden in the drift: sum of C |dT/dt| over the measured diffusion nodes, W.
    pub stored_w: f64,
    /// Whether it does not drift: no sensor is clearly steeper than the profile's limit; `None` without a limit.
    pub stabilised: Option<bool>,
    /// Whether it is steeper than the limit all the same, though no more than the scatter of the readings explains.
    #[serde(default)]
    pub unclear: bool,
}

/// A phase or transient that could not be predicted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FailedPhase {
    /// Measurement.
    pub measurement: String,
    /// Phase, or `transient`.
    pub phase: String,
    /// Why.
    pub reason: String,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Name of the parameters' state.
    pub state: String,
    /// Parameters used, SI: name, unit as written, value.
    pub parameters: Vec<(String, String, f64)>,
    /// Readings beside predictions.
    pub rows: Readings,
    /// By sensor.
    pub sensors: Vec<SensorSummary>,
    /// By phase or stretch of time.
    pub phases: Vec<PhaseSummary>,
    /// All readings in kelvin (where there are none, in the unit of the first sensor) that a fit may use.
    pub train: Deviation,
    /// The same of those held out.
    pub held_out: Deviation,
    /// Sum of squares over sigma squared, divided by the number of readings, where every sigma is known.
    pub chi2_per_reading: Option<f64>,
    /// Profile.
    pub criteria: Criteria,
    /// Outcome of each criterion.
    pub verdicts: Vec<Verdict>,
    /// Heat balances.
    pub heat: Vec<HeatBalance>,
    /// Trends, strongest first.
    pub trends: Vec<Trend>,
    /// Steadiness.
    pub stabilisation: Vec<StabilisationCheck>,
    /// Where it fails, in words, worst first; empty when it does not.
    pub fails: Vec<String>,
    /// What could not be predicted.
    pub failed: Vec<FailedPhase>,
    /// Columns of the data that nothing uses.
    pub unused_columns: Vec<String>,
    /// What is doubtful about the data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The tuned state, where a calibration stands behind the comparison.
    #[serde(default)]
    pub tuned: Option<TunedState>,
    /// Whether that calibration's chains converged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
}
