//! A prediction in brief.

use crate::job::predict::{Kind, Output};
use crate::report::number::Shown;
use crate::report::required::Standing;
use crate::report::section::brief::Brief;
use crate::report::section::propagation;
use crate::report::view::JobEntry;

/// A prediction in brief.
pub(in crate::report::section) struct Prediction;

impl Brief for Prediction {
    type Kind = Kind;

    /// With the posterior, and where the design reached what is required with the priors.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines = propagation::brief::headline(&output.posterior);
        let design = Shown::written(&output.posterior.design_unit);
        if let Some(name) = &output.posterior.design_variable {
            for reached in &output.prior.reached {
                let value =
                    reached.design_value.map_or_else(|| format!("no {name} of the sweep"), |value| design.text(value));
                lines.push(format!(
                    "with the priors, {} in {}: {value} reaches it",
                    reached.requirement, reached.environment
                ));
            }
        }
        if !output.converged {
            lines.push("the chains behind the posterior did NOT converge".to_owned());
        }
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        propagation::brief::essentials(&output.posterior)
    }

    fn standings(output: &Output) -> Vec<Standing> {
        propagation::brief::standings(&output.posterior)
    }
}
