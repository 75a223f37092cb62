//! Sensors that follow late, or whose clocks are off: what they read of the temperatures at the fit with times that are tried.

use super::blank::{Predictions, blank, blank_truth, predictions};
use super::probe::{Probes, share};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::effect::{Effect, SensorChange};
use crate::inference::likelihood::Datum;
use crate::measurement::timing::Timing;
use crate::measurement::{Measurement, Rows};

/// Share of a transient above which an offset of clocks is not tried there: little of what is shown is known then.
const MOST_OFFSET: f64 = 0.5;

/// What sensors read in every row, found when first asked for.
#[derive(Default)]
pub(super) struct Timings {
    found: Option<Result<Readings, FitError>>,
}

/// What sensors read at the fit.
struct Readings {
    /// What happens when it does.
    truths: Predictions,
    /// When the sensors show it.
    present: Option<Predictions>,
}

impl Readings {
    fn of(base: &Base<'_>) -> Result<Self, FitError> {
        let measurements = &base.problem.measurements;
        let mut sensors = measurements.iter().flat_map(|measurement| &measurement.sensors);
        let has_times = sensors.any(|one| one.lag_s.is_some() || one.behind_s.is_some());
        let truths = predictions(base, measurements.iter().map(blank_truth).collect())?;
        let present = has_times.then(|| predictions(base, measurements.iter().map(blank).collect())).transpose()?;
        Ok(Self { truths, present })
    }
}

impl Timings {
    /// The directions of an effect's times.
    pub fn directions(&mut self, base: &Base<'_>, position: usize, effect: &Effect) -> Found {
        let found = self.found.get_or_insert_with(|| Readings::of(base)).as_ref().map_err(Clone::clone)?;
        let Probes { applied, values, .. } = Probes::new(base, position, effect)?;
        let measurements = &base.problem.measurements;
        let change_of = |name: &str| applied.sensors.iter().find(|change| change.of_sensor() == Some(name));
        let read = |measurement: usize, sensor: usize, probe: &[f64]| -> Option<Vec<f64>> {
            let Measurement { sensors, rows: Rows::Transient { inputs, .. }, .. } = &measurements[measurement] else {
                return None;
            };
            let (own, times_s) = (&sensors[sensor], &inputs.times_s);
            let change = change_of(&own.name)?;
            let time_s = *probe.get(change.time()?.checked_sub(applied.first_parameter)?)?;
            let present = base.likelihood.timing(measurement, sensor, base.unknowns);
            let timing = match change {
                SensorChange::Clock { .. } => Timing { behind_s: time_s, ..present },
                _ => Timing { lag_s: time_s, ..present },
            };
            let span_s = times_s.last()? - times_s.first()?;
            let truth = found.truths[measurement].iter().skip(sensor).step_by(sensors.len());
            let truth: Vec<f64> = truth.copied().collect();
            (timing.behind_s.abs() <= MOST_OFFSET * span_s).then(|| timing.reading(times_s, &truth))
        };
        let present = found.present.as_ref().unwrap_or(&found.truths);
        let mut directions = Vec::new();
        for probe in values {
            let readings: Vec<Vec<Option<Vec<f64>>>> = (measurements.iter().enumerate())
                .map(|(place, own)| (0..own.sensors.len()).map(|sensor| read(place, sensor, &probe)).collect())
                .collect();
            let change = |&Datum { measurement, row, sensor }: &Datum| {
                let now = present[measurement][row * measurements[measurement].sensors.len() + sensor];
                readings[measurement][sensor].as_ref().map_or(0.0, |read| read[row] - now)
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
