//! What of a pass is diagnosed: its model with all its measurements, and every effect of the catalogue at every place.

use std::sync::Arc;

use crate::diagnosis::Problem;
use crate::effect::candidates;
use crate::thermal::Model;

use super::ready::input_errors;
use super::resolve::adopt::sensor_places;
use super::resolved::Pass;

/// The problem of a pass over all its measurements.
pub fn problem(pass: &Pass) -> Problem {
    let sensors = sensor_places(pass.measurements.iter());
    let problem = Problem {
        candidates: candidates(&pass.model, &pass.groups, &sensors, &pass.catalogue),
        model: Arc::new(Model { keeps_signs: false, ..pass.model.clone() }),
        priors: pass.priors.clone(),
        parameters: (0..pass.priors.len()).filter(|&index| !pass.priors[index].is_fixed()).collect(),
        measurements: pass.measurements.clone(),
        input_errors: input_errors(pass),
        catalogue: Arc::clone(&pass.catalogue),
        joint: Vec::new(),
        most_steps: Vec::new(),
    };
    problem.with_something_to_infer()
}
