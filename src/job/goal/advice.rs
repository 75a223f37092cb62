//! What to do next, and why.
//!
//! An experiment that infers the leading parameters where better knowledge of them is enough; an experiment that validates the model
//! where the requirements are met already, or no parameter leads; nothing where they are met with the discrepancy that a validation
//! found; another design where no knowledge is enough.

use super::output::{Advice, Next, Output};

/// Below this sum of main effects no set of parameters leads.
const LEADS: f64 = 0.5;

/// The advice that a result leads to.
pub fn advice(output: &Output) -> Advice {
    let mut reasons = Vec::new();
    let probability = &output.probability;
    let next = if probability.value >= output.required {
        reasons.push(format!(
            "the given design meets all requirements with a probability of {:.4} (95 %: {:.4} to {:.4}), {} is required",
            probability.value, probability.lower, probability.upper, output.required
        ));
        if probability.lower < output.required {
            reasons.push("these samples leave it open whether it is enough: take more".to_owned());
        }
        if output.discrepancy.is_empty() {
            reasons.push("this takes the model for exact: nothing is known yet of its discrepancy".to_owned());
            Next::Validation
        } else {
            reasons.push("the discrepancy that a validation experiment found is part of it".to_owned());
            Next::Done
        }
    } else {
        reasons.push(format!(
            "the given design meets all requirements with a probability of {:.4} (95 %: {:.4} to {:.4}), {} is required; {} \
             in environment {} drives",
            probability.value,
            probability.lower,
            probability.upper,
            output.required,
            output.driving.requirement,
            output.driving.environment
        ));
        missed(output, &mut reasons)
    };
    Advice { next, reasons }
}

/// The advice where the requirements are missed.
fn missed(output: &Output, reasons: &mut Vec<String>) -> Next {
    if let Some(target) = &output.target {
        reasons.push(format!(
            "it is enough to know {} to {:.1} % of the prior standard deviation, {:.1} % of the variance",
            together(&target.parameters),
            100.0 * target.ratio,
            100.0 * target.variance_ratio
        ));
        if let Some(truths) = &output.truths {
            reasons.push(format!(
                "over truths drawn from the prior such an experiment then shows the required probability in {:.0} % of the cases",
                100.0 * truths.reaching.value
            ));
        }
        return Next::ParameterInference;
    }
    let best = output.knowledge.iter().filter_map(|knowledge| Some((knowledge, knowledge.levels.last()?))).next_back();
    if let Some((knowledge, level)) = best {
        reasons.push(format!(
            "not even perfect knowledge of {} is enough: the probability then is {:.4}",
            together(&knowledge.parameters),
            level.probability.value
        ));
    } else {
        reasons.push("no parameter has a main effect on the driving quantity".to_owned());
    }
    let main = |name: &String| {
        let leading = output.leading.iter().find(|leading| leading.parameter == *name);
        leading.and_then(|leading| leading.main).map_or(0.0, |main| main.value)
    };
    let led: f64 = best.map_or(0.0, |(knowledge, _)| knowledge.parameters.iter().map(main).sum());
    let has_value = output.prior_design_value.is_some()
        || best.is_some_and(|(knowledge, _)| knowledge.levels.iter().any(|level| level.design_value.is_some()));
    if led < LEADS && !has_value {
        reasons.push(format!(
            "together they have {:.0} % of the driving quantity's variance: no parameter leads, so look at the model as a whole",
            100.0 * led
        ));
        return Next::Validation;
    }
    Next::Redesign
}

/// a, a and b.
fn together(names: &[String]) -> String {
    names.join(" and ")
}
