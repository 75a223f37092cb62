//! Two sensors whose channels are exchanged: each reads what the other would.

use super::blank::{Predictions, blank, predictions};
use super::probe::share;
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::effect::Site;

/// Predictions of every sensor at every row that is fitted, found when first asked for.
#[derive(Default)]
pub(super) struct Swaps {
    predictions: Option<Result<Predictions, FitError>>,
}

impl Swaps {
    /// The direction of a pair of sensors: amplitude 1 is the exchange.
    pub fn direction(&mut self, base: &Base<'_>, position: usize) -> Found {
        let found = || predictions(base, base.problem.measurements.iter().map(blank).collect());
        let predictions = self.predictions.get_or_insert_with(found).as_ref().map_err(Clone::clone)?;
        let Site::Sensors(sensors) = &base.problem.candidates[position].site else {
            return Err(NoDirection::NoSensors.into());
        };
        let [a, b] = sensors.as_slice() else { return Err(NoDirection::NotTwoSensors.into()) };
        let pairs: Vec<Option<[usize; 2]>> = (base.problem.measurements.iter())
            .map(|measurement| {
                let find = |name: &str| measurement.sensors.iter().position(|sensor| sensor.name == name);
                Some([find(&a.name)?, find(&b.name)?])
            })
            .collect();
        let mut column = vec![0.0; base.residuals.len()];
        for (value, datum) in column.iter_mut().zip(base.likelihood.data()) {
            let Some([a, b]) = pairs[datum.measurement] else { continue };
            let other = match datum.sensor {
                sensor if sensor == a => b,
                sensor if sensor == b => a,
                _ => continue,
            };
            let count = base.problem.measurements[datum.measurement].sensors.len();
            let at = |sensor: usize| predictions[datum.measurement][datum.row * count + sensor];
            *value = at(other) - at(datum.sensor);
        }
        if column.iter().all(|value| *value == 0.0) {
            return Err(NoDirection::NoDifference.into());
        }
        base.whitening.apply(&mut column)?;
        column.resize(base.rows, 0.0);
        Ok(vec![share(position, column, Vec::new())])
    }
}
