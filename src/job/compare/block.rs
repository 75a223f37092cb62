//! A block of a comparison: what is predicted of a measurement, and what follows from that.

use serde::{Deserialize, Serialize};

use super::output::{FailedPhase, HeatBalance, PhaseSummary, SensorSummary, StabilisationCheck, Trend};
use crate::job::{JobError, stored};

/// Part of the result that belongs to one measurement. What was measured is known to whoever joins the parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Predictions of its readings, rows x sensors, SI.
    pub predicted: Vec<f64>,
    /// The same of the tuned state; empty without one.
    pub tuned: Vec<f64>,
    /// All that is short.
    pub summary: Summary,
}

/// What follows from the predictions of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// By sensor.
    pub sensors: Vec<SensorSummary>,
    /// By phase or stretch of time.
    pub phases: Vec<PhaseSummary>,
    /// Heat balances.
    pub heat: Vec<HeatBalance>,
    /// Trends.
    pub trends: Vec<Trend>,
    /// Steadiness.
    pub stabilisation: Vec<StabilisationCheck>,
    /// What could not be predicted.
    pub failed: Vec<FailedPhase>,
    /// Columns of the data that nothing uses.
    pub unused_columns: Vec<String>,
    /// Sum of squares over sigma squared, and number of readings.
    pub chi2: Option<(f64, u64)>,
}

/// The summary and the number of delivered predictions, then the predictions.
impl stored::Block for Part {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        stored::with_numbers(&(self.summary, self.predicted.len()), &[self.predicted, self.tuned].concat())
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((summary, length), mut predicted): ((Summary, usize), Vec<f64>) = stored::split_numbers(bytes, stage)?;
        if length > predicted.len() {
            return Err(stored::unreadable(stage, "it is cut off"));
        }
        let tuned = predicted.split_off(length);
        Ok(Self { predicted, tuned, summary })
    }
}
