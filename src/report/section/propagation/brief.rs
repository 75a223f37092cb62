//! A propagation in brief.

use crate::document::counted;
use crate::job::propagate::{Kind, Met, Output};
use crate::report::number::{self, Shown};
use crate::report::page::Status;
use crate::report::required::Standing;
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::{nominal_cases, outcome, standing};

/// A propagation in brief.
pub(in crate::report::section) struct Propagation;

impl Brief for Propagation {
    type Kind = Kind;

    /// Probability of each requirement at the nominal design, and where the design reaches what is required.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        headline(output)
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        essentials(output)
    }

    fn standings(output: &Output) -> Vec<Standing> {
        standings(output)
    }
}

/// Probability of each requirement at the nominal design, and where the design reaches what is required.
pub(in crate::report::section) fn headline(output: &Output) -> Vec<String> {
    let mut lines = Vec::new();
    let design = Shown::written(&output.design_unit);
    let has_one_environment = nominal_cases(output).all(|c| c.environment == output.cases[0].environment);
    for case in nominal_cases(output) {
        let place = if has_one_environment { String::new() } else { format!(" in {}", case.environment) };
        for met in &case.requirements {
            let outcome = outcome(met);
            let reached = output
                .reached
                .iter()
                .find(|r| r.environment == case.environment && r.requirement == met.requirement)
                .zip(output.design_variable.as_ref())
                .map_or(String::new(), |(reached, name)| match reached.design_value {
                    Some(value) => format!("; {name} = {} reaches it", design.text(value)),
                    None => format!("; no {name} of the sweep reaches it"),
                });
            lines.push(format!(
                "P({}) = {}{place}, required {}: {outcome}{reached}",
                met.requirement,
                number::probability(met.probability.value),
                number::probability(met.required),
            ));
        }
        if case.requirements.is_empty() {
            lines.extend(case.quantities.iter().map(|q| {
                let shown = Shown::quantity(&q.unit, q.is_temperature);
                let spread = shown.difference().text(q.sd);
                format!("{} = {}, standard deviation {spread}{place}", q.name, shown.text(q.mean))
            }));
        }
        if case.failed > 0 {
            let samples = counted(output.samples, "sample");
            lines.push(format!("no solution in {} of {samples}{place}", case.failed));
        }
    }
    lines
}

/// Probabilities, means and spreads at the nominal design.
pub(in crate::report::section) fn essentials(output: &Output) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    let has_one = nominal_cases(output).count() == 1;
    for case in nominal_cases(output) {
        let place = if has_one { String::new() } else { format!(" in {}", case.environment) };
        for met in &case.requirements {
            rows.push((format!("P({}){place}", met.requirement), number::probability(met.probability.value)));
        }
        for quantity in &case.quantities {
            let shown = Shown::quantity(&quantity.unit, quantity.is_temperature);
            rows.push((format!("{}, mean{place}", quantity.name), shown.text(quantity.mean)));
            rows.push((format!("{}, standard deviation{place}", quantity.name), shown.difference().text(quantity.sd)));
        }
        rows.push((format!("samples without a solution{place}"), case.failed.to_string()));
    }
    rows
}

/// How each requirement stands at the nominal design.
pub(in crate::report::section) fn standings(output: &Output) -> Vec<Standing> {
    let cases = nominal_cases(output);
    cases.flat_map(|case| case.requirements.iter().map(|met| of_requirement(&case.environment, met))).collect()
}

/// How a requirement stands in an environment.
pub fn of_requirement(environment: &str, met: &Met) -> Standing {
    let (value, required) = (number::probability(met.probability.value), number::probability(met.required));
    let name = &met.requirement;
    Standing {
        words: format!("P({name}) = {value} in {environment}, required {required}: {}", outcome(met)),
        is_met: standing(met) == Status::Ok,
    }
}
