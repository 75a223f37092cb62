//! Data that cannot show what is missing, or hardly where: few readings, one sensor, one phase, inputs that never move.

use std::collections::BTreeSet;

use crate::diagnosis::Problem;
use crate::diagnosis::problem::FittedReading;
use crate::measurement::Rows;

/// What is said of the readings that are fitted with so many free parameters.
pub fn warnings(problem: &Problem, free: usize) -> Vec<String> {
    let readings = problem.fitted_readings();
    let mut said = Vec::new();
    if readings.len() <= free {
        said.push(format!(
            "{} readings are fitted with {free} free parameters: the model can follow whatever is measured, so that these data test \
             nothing. Measure more phases, add sensors, or fix parameters that are known",
            readings.len()
        ));
    }
    let name = |one: &FittedReading| problem.measurements[one.measurement].sensors[one.sensor].name.as_str();
    if let Some(first) = readings.first()
        && readings.iter().all(|one| name(one) == name(first))
    {
        said.push(format!(
            "only one sensor is fitted, `{}`: it can show that something is missing, but hardly where",
            name(first)
        ));
    }
    let rows = |one: &FittedReading| (one.measurement, one.row);
    if let Some(first) = readings.first()
        && let Rows::Steady(phases) = &problem.measurements[first.measurement].rows
        && readings.iter().all(|one| rows(one) == rows(first))
    {
        said.push(format!(
            "only one phase is fitted, `{}`: what goes with an input or a temperature looks like something constant",
            phases[first.row].name
        ));
    } else {
        said.extend(still_inputs(problem, &readings));
    }
    said
}

/// What is said of inputs of effects that are the same in all rows that are fitted.
fn still_inputs(problem: &Problem, readings: &[FittedReading]) -> Option<String> {
    let used: BTreeSet<usize> =
        problem.candidates.iter().flat_map(|candidate| candidate.inputs(&problem.model)).collect();
    let is_still = |&input: &usize| {
        let level = |one: &FittedReading| problem.measurements[one.measurement].level(&problem.model, one.row, input);
        let first = readings.first().and_then(level);
        first.is_some() && readings.iter().all(|one| level(one) == first)
    };
    let inputs = used.iter().filter(|input| is_still(input));
    let named: Vec<String> = inputs.map(|&input| format!("`{}`", problem.model.inputs[input].name)).collect();
    (!named.is_empty()).then(|| {
        format!(
            "the same in all rows that are fitted: {}; an effect that goes with such an input looks like a constant one",
            named.join(", ")
        )
    })
}
