//! The tuned state beside the delivered one, and what the noise alone would leave.

use serde::Deserialize;
use serde_json::Value;

use super::deviation::deviation;
use super::output::{Deviation, Row, SensorSummary, TunedSensor, TunedState};
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

    /// Adds the tuned predictions to the rows of a measurement, and their statistics to its sensors.
    pub(super) fn add(
        &self,
        predictor: &Predictor,
        model: &Model,
        delivered: &[f64],
        measurement: &Measurement,
        criteria: &Criteria,
        rows: &mut [Row],
        sensors: &mut [SensorSummary],
    ) {
        let inputs: Vec<String> = model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = model.nodes.iter().map(|node| node.name.clone()).collect();
        let fixed = with_unknowns(measurement, &inputs, &nodes, &|name| self.find(name));
        let parameters = self.parameters(model, delivered);
        let prediction = predictor.predict(&mut predictor.workspace(), &fixed, &parameters);
        let place = |row: &Row| -> Option<usize> {
            let sensor = measurement.sensors.iter().position(|sensor| sensor.name == row.sensor)?;
            let position = match &measurement.rows {
                Rows::Steady(phases) => phases.iter().position(|phase| Some(&phase.name) == row.phase.as_ref())?,
                Rows::Transient { inputs, .. } => {
                    let time_s = row.time_s?;
                    inputs.times_s.partition_point(|instant_s| *instant_s < time_s)
                }
            };
            Some(position * measurement.sensors.len() + sensor)
        };
        for row in rows.iter_mut() {
            let tuned_reading = place(row).and_then(|place| prediction.readings.get(place)).copied();
            row.predicted_tuned = tuned_reading.filter(|value| value.is_finite());
        }
        for (summary, sensor) in sensors.iter_mut().zip(&fixed.sensors) {
            let of = |held_out: bool| {
                statistics(rows.iter().filter(|row| row.sensor == summary.sensor), held_out, criteria.each_k)
            };
            summary.tuned = Some(TunedSensor {
                train: of(false),
                held_out: of(true),
                sigma: known(&sensor.sigma),
                noise_rmse: noise_rmse(&fixed, sensor, rows),
            });
        }
    }

    /// The tuned state as a whole; `rows` are those of one unit, as its statistics are over several sensors.
    pub fn state(&self, model: &Model, delivered: &[f64], rows: &[&Row], limit: Option<f64>) -> TunedState {
        let parameters = self.parameters(model, delivered);
        TunedState {
            job: self.job.clone(),
            parameters: (model.parameters.iter().zip(parameters))
                .map(|(parameter, value)| (parameter.name.clone(), parameter.unit.clone(), value))
                .collect(),
            train: statistics(rows.iter().copied(), false, limit),
            held_out: statistics(rows.iter().copied(), true, limit),
        }
    }
}

fn statistics<'r>(rows: impl Iterator<Item = &'r Row>, held_out: bool, limit: Option<f64>) -> Deviation {
    let chosen_rows = rows.filter(|row| row.held_out == held_out);
    let deviations: Vec<f64> = chosen_rows.filter_map(|row| Some(row.measured - row.predicted_tuned?)).collect();
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
/// (Satterthwaite 1946).
fn noise_rmse(measurement: &Measurement, sensor: &Sensor, rows: &[Row]) -> Option<[f64; 2]> {
    let sigma = known(&sensor.sigma)?;
    let white = known(&sensor.white).unwrap_or(0.0);
    let total = sigma * sigma + white * white;
    let sensor_rows: Vec<&Row> = rows.iter().filter(|row| row.sensor == sensor.name).collect();
    let count = sensor_rows.len() as f64;
    let mut squares = count;
    if let (Rows::Transient { .. }, Some(correlation)) = (&measurement.rows, &sensor.correlation_time_s) {
        let tau_s = correlation.nominal();
        let times: Vec<f64> = sensor_rows.iter().filter_map(|row| row.time_s).collect();
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
