//! What of a pass is diagnosed: its model with measurements, and every effect of the catalogue at every place.

use std::sync::Arc;

use crate::diagnosis::{Problem, working_temperatures_k};
use crate::effect::candidates;
use crate::inference::likelihood::InputError;
use crate::measurement::{Measurement, sensor_places};
use crate::thermal::Model;

use super::model::Prior;
use super::resolved::Pass;

/// The problem of a pass over all its measurements.
pub fn problem(pass: &Pass) -> Problem {
    let parameters = (0..pass.priors.len()).filter(|&index| !pass.priors[index].is_fixed()).collect();
    problem_with(pass, pass.measurements.clone(), parameters).with_something_to_infer()
}

/// The problem of a pass over these of its measurements, with these of its parameters inferred.
pub fn problem_with(pass: &Pass, measurements: Vec<Measurement>, parameters: Vec<usize>) -> Problem {
    let (model, measurements) = dated(pass, measurements);
    let sensors = sensor_places(measurements.iter());
    let working_temperatures_k = Arc::new(working_temperatures_k(&model, &measurements));
    Problem {
        candidates: Arc::new(candidates(&model, &pass.groups, &sensors, &pass.catalogue)),
        model: Arc::new(Model { keeps_signs: false, ..model }),
        priors: pass.priors.clone(),
        parameters,
        measurements,
        input_errors: input_errors(pass),
        catalogue: Arc::clone(&pass.catalogue),
        joint: Vec::new(),
        most_steps: Vec::new(),
        noise_freedom: None,
        is_misspecified: false,
        independent_readings: 0.0,
        considered: Vec::new(),
        working_temperatures_k,
        places: Default::default(),
        missing_probability: Default::default(),
        tolerance: 1.0,
    }
}

/// The model of a pass with the input that says when, and these measurements with their values of it.
pub fn dated(pass: &Pass, mut measurements: Vec<Measurement>) -> (Model, Vec<Measurement>) {
    let mut model = pass.model.clone();
    model.set_clocks(&pass.measurements, &mut measurements);
    (model, measurements)
}

/// Own errors of the inputs; a prior from draws was refused when the pass was read.
pub fn input_errors(pass: &Pass) -> Vec<InputError> {
    let bias = |prior: &Option<Prior>| match prior {
        Some(Prior::Distribution(distribution)) => Some(*distribution),
        _ => None,
    };
    pass.input_errors.iter().map(|error| InputError { sigma: error.sigma, bias: bias(&error.bias) }).collect()
}
