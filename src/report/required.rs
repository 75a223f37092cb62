//! Whether the requirements of a study are met by the given design.

use crate::job::propagate::{Met, Output};

use super::number;
use super::page::Status;
use super::section::propagation::{nominal_cases, standing};
use super::view::JobResult;

/// A requirement, and how it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Standing {
    /// In a sentence's part.
    pub words: String,
    /// Whether it is met; not where the samples leave that open.
    pub is_met: bool,
}

/// What a job's result says of the requirements.
pub fn standings(result: &JobResult) -> Vec<Standing> {
    match result {
        JobResult::Propagate(output) => of_propagation(output),
        JobResult::Predict(output) => of_propagation(&output.posterior),
        _ => Vec::new(),
    }
}

/// How a requirement stands, in words.
pub(super) fn outcome(met: &Met) -> &'static str {
    match standing(met) {
        Status::Ok => "met",
        Status::Caution => "undecided with these samples",
        Status::Fail => "not met",
    }
}

fn of_propagation(output: &Output) -> Vec<Standing> {
    let cases = nominal_cases(output);
    cases.flat_map(|case| case.requirements.iter().map(|met| of_requirement(&case.environment, met))).collect()
}

fn of_requirement(environment: &str, met: &Met) -> Standing {
    let (value, required) = (number::probability(met.probability.value), number::probability(met.required));
    let name = &met.requirement;
    Standing {
        words: format!("P({name}) = {value} in {environment}, required {required}: {}", outcome(met)),
        is_met: standing(met) == Status::Ok,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::propagate::Probability;

    #[test]
    fn what_the_samples_leave_open_is_not_met() {
        let standing = |lower, value, upper| {
            let met = Met {
                requirement: "detector".into(),
                probability: Probability { value, lower, upper },
                required: 0.99,
                below: Some(140.0),
                above: None,
                unit: "K".into(),
                quantity: "detector temperature".into(),
            };
            of_requirement("nominal", &met)
        };
        assert!(standing(0.991, 0.995, 0.998).is_met);
        let open = standing(0.985, 0.992, 0.996);
        assert_eq!(
            (open.is_met, open.words.as_str()),
            (false, "P(detector) = 0.992 in nominal, required 0.990: undecided with these samples")
        );
        assert!(!standing(0.5, 0.6, 0.7).is_met);
    }
}
