//! Surroundings that are fitted where no logged temperature was: the loss may not follow what was logged, or stand for something else.

use std::collections::BTreeMap;

use crate::diagnosis::Problem;
use crate::diagnosis::odds::medium::logged_temperatures;
use crate::diagnosis::output::Amount;
use crate::diagnosis::verdict::numbers::degrees;
use crate::effect::Candidate;
use crate::expression::Unit;

/// Distance from a logged range up to which surroundings are those that were logged, K: a sensor's error, or a wall beside the air.
const SAME_K: f64 = 3.0;
/// Distance from which they are others than those that were logged, K.
const OTHERS_K: f64 = 40.0;

/// What is to be checked where an effect leads to surroundings of its own, whose temperature is among the `amplitudes`.
pub fn hint(problem: &Problem, candidate: &Candidate, amplitudes: &BTreeMap<String, Amount>) -> Option<String> {
    let ambient = problem.catalogue.get(&candidate.effect)?.form.adds.value.ambient.as_ref()?;
    let fitted = amplitudes.get(&ambient.temperature.value)?;
    let fitted_k = Unit::parse(&fitted.unit).ok()?.to_si(fitted.value);
    let logged = logged_temperatures(problem);
    let distance = |[least, most]: [f64; 2]| f64::max(least - fitted_k, fitted_k - most);
    let (input, range) = logged.into_iter().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
    let apart = distance(range);
    (apart > SAME_K.max(fitted.sd) && apart < OTHERS_K).then(|| {
        format!(
            "The temperature that fits its surroundings, {} degC, was never logged: `{}`, the nearest, was {} to {} degC. Another law, or \
             a second loss, may be what asks for it.",
            degrees(fitted_k),
            problem.model.inputs[input].name,
            degrees(range[0]),
            degrees(range[1])
        )
    })
}
