//! The tuned state beside the delivered one, and what the noise alone would leave.

use serde::Deserialize;
use serde_json::Value;

use super::deviation::deviation;
use super::output::{Deviation, SensorSummary, TunedSensor, TunedState};
use super::readings::{Row, Table};
use crate::job::JobError;
use crate::math::functions::exp;
use crate::math::special::chi_square_quantile;
use crate::measurement::prediction::Predictor;
use crate::measurement::unknown::with_unknowns;
use crate::measurement::{Measurement, Rows, Sensor, Uncertain};
use crate::study::profile::Criteria;
use crate::thermal::Model;

/// Correlation times beyond which readings count as independent: the correlation is e^-12 there.
const FAR: f64 = 12.0;

/// The most probable state of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// Name of the calibration.
    pub job: String,
    /// Parameters with their most probable values, SI.
    pub values: Vec<(String, f64)>,
    /// Number of unknowns that were inferred.
    pub unknowns: usize,
    /// Whether its search converged.
    pub converged: bool,
}

/// The part of a calibration's result that is used.
#[derive(Deserialize)]
struct Calibrated {
    tuned: Vec<(String, f64)>,
    #[serde(default)]
    order: Vec<String>,
    converged: bool,
}

impl Tuned {
    /// From the result of the calibration of this name.
    ///
    /// # Errors
    /// A result that holds no tuned state.
    pub fn from_result(job: &str, result: &Value) -> Result<Self, JobError> {
        let calibrated = Calibrated::deserialize(result)
            .map_err(|error| JobError::Failed(format!("the result of `{job}` has no tuned state: {error}")))?;
        let unknowns = if calibrated.order.is_empty() { calibrated.tuned.len() } else { calibrated.order.len() };
        Ok(Self { job: job.to_owned(), values: calibrated.tuned, unknowns, converged: calibrated.converged })
    }

    /// Number of unknowns that the calibration inferred, at most.
    pub(super) fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Whether the calibration's chains converged.
    pub(super) fn converged(&self) -> bool {
        self.converged
    }

    /// The value of a parameter, SI; `None` if it was not inferred.
    pub fn find(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(parameter_name, _)| parameter_name == name).map(|(_, value)| *value)
    }

    /// All parameters of the model, SI: tuned, or as delivered where the calibration did not choose them.
    fn parameters(&self, model: &Model, delivered: &[f64]) -> Vec<f64> {
        let delivered_parameters = model.parameters.iter().zip(delivered);
        delivered_parameters.map(|(parameter, delivered)| self.find(&parameter.name).unwrap_or(*delivered)).collect()
    }

    /// What is predicted of a measurement's readings, and the measurement with its unknowns as tuned.
    pub(super) fn predicted(
        &self,
        predictor: &Predictor,
        model: &Model,
        delivered: &[f64],
        measurement: &Measurement,
    ) -> (Measurement, Vec<f64>) {
        let inputs: Vec<String> = model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = model.nodes.iter().map(|node| node.name.clone()).collect();
        let fixed = with_unknowns(measurement, &inputs, &nodes, &|name| self.find(name));
        let parameters = self.parameters(model, delivered);
        let prediction = predictor.predict(&mut predictor.workspace(), &fixed, &parameters);
        (fixed, prediction.readings)
    }

    /// Adds what tuning made of them to the sensors of a measurement, which has its unknowns as tuned.
    pub(super) fn add(fixed: &Measurement, criteria: &Criteria, table: &Table, sensors: &mut [SensorSummary]) {
        for (position, (summary, sensor)) in sensors.iter_mut().zip(&fixed.sensors).enumerate() {
            let of = |held_out: bool| statistics(table.column(position), held_out, criteria.each_k);
            let times: Vec<f64> = table.column(position).filter_map(|row| row.time_s).collect();
            summary.tuned = Some(TunedSensor {
                train: of(false),
                held_out: of(true),
                sigma: known(&sensor.sigma),
                noise_rmse: noise_rmse(fixed, sensor, table.column(position).count(), &times),
            });
        }
    }

    /// The tuned state as a whole; `rows` gives those of one unit, as its statistics are over several sensors.
    pub fn state<'r, R: Iterator<Item = Row<&'r str>>>(
        &self,
        model: &Model,
        delivered: &[f64],
        rows: impl Fn() -> R,
        limit: Option<f64>,
    ) -> TunedState {
        let parameters = self.parameters(model, delivered);
        TunedState {
            job: self.job.clone(),
            parameters: (model.parameters.iter().zip(parameters))
                .map(|(parameter, value)| (parameter.name.clone(), parameter.unit.clone(), value))
                .collect(),
            train: statistics(rows(), false, limit),
            held_out: statistics(rows(), true, limit),
        }
    }
}

fn statistics<'r>(rows: impl Iterator<Item = Row<&'r str>>, held_out: bool, limit: Option<f64>) -> Deviation {
    let chosen_rows = rows.filter(|row| row.held_out == held_out);
    let deviations: Vec<f64> = chosen_rows.filter_map(|row| row.tuned_deviation()).collect();
    deviation(&deviations, limit)
}

fn known(value: &Option<Uncertain>) -> Option<f64> {
    match value {
        Some(Uncertain::Known(value)) => Some(*value),
        _ => None,
    }
}

/// The range in which the RMSE over a sensor's rows lies with 95 % probability when only its noise is at work: the mean
/// square is taken as a scaled chi-square whose degrees of freedom match its variance, `n^2 / sum rho_ij^2`
/// (Satterthwaite 1946). `times` are the instants of its rows, where it is a transient's.
fn noise_rmse(measurement: &Measurement, sensor: &Sensor, rows: usize, times: &[f64]) -> Option<[f64; 2]> {
    let sigma = known(&sensor.sigma)?;
    let white = known(&sensor.white).unwrap_or(0.0);
    let total = sigma * sigma + white * white;
    let count = rows as f64;
    let mut squares = count;
    if let (Rows::Transient { .. }, Some(correlation)) = (&measurement.rows, &sensor.correlation_time_s) {
        let tau_s = correlation.nominal();
        let share = sigma * sigma / total;
        for first in 0..times.len() {
            for second in first + 1..times.len() {
                let apart = (times[second] - times[first]) / tau_s;
                if !(apart < FAR) {
                    break;
                }
                let correlation = share * exp(-apart);
                squares += 2.0 * correlation * correlation;
            }
        }
    }
    let freedom = count * count / squares;
    (count > 0.0 && total > 0.0)
        .then(|| [0.025, 0.975].map(|share| (total * chi_square_quantile(share, freedom) / freedom).sqrt()))
}
