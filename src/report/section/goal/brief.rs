//! A goal setting in brief.

use crate::job::goal::{Kind, Output};
use crate::report::headline::MOST_FINDINGS;
use crate::report::number::{self, NONE, Shown};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::next_words;

/// A goal setting in brief.
pub(in crate::report::section) struct Goal;

impl Brief for Goal {
    type Kind = Kind;

    /// What to do next, and why.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines = vec![format!("next: {}", next_words(output.advice.next))];
        lines.extend(output.advice.reasons.iter().take(MOST_FINDINGS).cloned());
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let design = Shown::written(&output.design_unit);
        let mut rows = vec![
            ("next step".to_owned(), next_words(output.advice.next).to_owned()),
            ("why".to_owned(), output.advice.reasons.join("; ")),
            ("P(all requirements)".to_owned(), number::probability(output.probability.value)),
        ];
        for met in &output.requirements {
            rows.push((
                format!("P({}) in {}", met.requirement, met.environment),
                number::probability(met.probability.value),
            ));
        }
        if let Some(name) = &output.design_variable {
            let value = output.prior_design_value.map_or_else(|| NONE.to_owned(), |value| design.text(value));
            rows.push((format!("{name} that the priors reach"), value));
        }
        if let Some(target) = &output.target {
            for ((name, unit), sd) in target.parameters.iter().zip(&target.units).zip(&target.sds) {
                let text = Shown::parameter_of(unit, *sd).difference().text(*sd);
                rows.push((format!("{name}: standard deviation that may be left"), text));
            }
        }
        rows
    }
}
