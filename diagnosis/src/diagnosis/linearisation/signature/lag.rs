//! Sensors that follow late: what they read of the temperatures at the fit with time constants that are tried.

use super::blank::{Predictions, blank, blank_truth, predictions};
use super::probe::{Probes, share};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::effect::{Effect, SensorChange};
use crate::inference::likelihood::Datum;
use crate::measurement::{Measurement, Rows, lag};

/// What sensors read in every row, found when first asked for.
#[derive(Default)]
pub(super) struct Lags {
    found: Option<Result<Readings, FitError>>,
}

/// What sensors read at the fit.
struct Readings {
    /// Without lags.
    truths: Predictions,
    /// With those that they have.
    present: Option<Predictions>,
}

impl Readings {
    fn of(base: &Base<'_>) -> Result<Self, FitError> {
        let measurements = &base.problem.measurements;
        let has_lag = measurements.iter().flat_map(|measurement| &measurement.sensors).any(|one| one.lag_s.is_some());
        let truths = predictions(base, measurements.iter().map(blank_truth).collect())?;
        let present = has_lag.then(|| predictions(base, measurements.iter().map(blank).collect())).transpose()?;
        Ok(Self { truths, present })
    }
}

impl Lags {
    /// The directions of an effect's time constants.
    pub fn directions(&mut self, base: &Base<'_>, position: usize, effect: &Effect) -> Found {
        let found = self.found.get_or_insert_with(|| Readings::of(base)).as_ref().map_err(Clone::clone)?;
        let Probes { applied, values, .. } = Probes::new(base, position, effect)?;
        let measurements = &base.problem.measurements;
        let parameter_of = |name: &str| {
            applied.sensors.iter().find_map(|change| match change {
                SensorChange::Lag { sensor, parameter } if sensor == name => {
                    parameter.checked_sub(applied.first_parameter)
                }
                _ => None,
            })
        };
        let late = |measurement: usize, sensor: usize, probe: &[f64]| -> Option<Vec<f64>> {
            let Measurement { sensors, rows: Rows::Transient { inputs, .. }, .. } = &measurements[measurement] else {
                return None;
            };
            let lag_s = *probe.get(parameter_of(&sensors[sensor].name)?)?;
            let truth = found.truths[measurement].iter().skip(sensor).step_by(sensors.len());
            Some(lag::reading(&inputs.times_s, &truth.copied().collect::<Vec<f64>>(), lag_s))
        };
        let present = found.present.as_ref().unwrap_or(&found.truths);
        let mut directions = Vec::new();
        for probe in values {
            let readings: Vec<Vec<Option<Vec<f64>>>> = (measurements.iter().enumerate())
                .map(|(place, own)| (0..own.sensors.len()).map(|sensor| late(place, sensor, &probe)).collect())
                .collect();
            let change = |&Datum { measurement, row, sensor }: &Datum| {
                let now = present[measurement][row * measurements[measurement].sensors.len() + sensor];
                readings[measurement][sensor].as_ref().map_or(0.0, |late| late[row] - now)
            };
            let mut column: Vec<f64> = base.likelihood.data().iter().map(change).collect();
            base.whitening.apply(&mut column)?;
            column.resize(base.rows, 0.0);
            if column.iter().all(|value| value.is_finite()) && column.iter().any(|value| *value != 0.0) {
                directions.push(share(position, column, probe));
            }
        }
        if directions.is_empty() { Err(NoDirection::NoReading.into()) } else { Ok(directions) }
    }
}
