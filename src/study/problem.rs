//! What of a pass is diagnosed: its model with all its measurements, and every effect of a catalogue at every place.

use std::sync::Arc;

use crate::diagnosis::Problem;
use crate::effect::{Catalogue, GroupPlace, SensorPlace, candidates};
use crate::inference::measurement::Rows;

use super::ready::input_errors;
use super::resolved::Pass;

/// The problem of a pass over all its measurements. `groups` are the model's.
pub fn problem(pass: &Pass, catalogue: &Arc<Catalogue>, groups: &[GroupPlace]) -> Problem {
    let mut sensors: Vec<SensorPlace> = Vec::new();
    for measurement in &pass.measurements {
        let transient = matches!(measurement.rows, Rows::Transient { .. });
        for own in &measurement.sensors {
            match sensors.iter_mut().find(|sensor| sensor.name == own.name && sensor.quantity == own.quantity) {
                Some(sensor) => {
                    sensor.steady |= !transient;
                    sensor.transient |= transient;
                }
                None => sensors.push(SensorPlace {
                    name: own.name.clone(),
                    quantity: own.quantity,
                    steady: !transient,
                    transient,
                }),
            }
        }
    }
    Problem {
        candidates: candidates(&pass.model, groups, &sensors, catalogue),
        model: Arc::new(pass.model.clone()),
        priors: pass.priors.clone(),
        parameters: (0..pass.priors.len()).filter(|&index| !pass.priors[index].is_fixed()).collect(),
        measurements: pass.measurements.clone(),
        input_errors: input_errors(pass),
        catalogue: Arc::clone(catalogue),
    }
}
