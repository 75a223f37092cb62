//! A calibration in brief.

use crate::job::calibrate::{Kind, Output};
use crate::report::headline::MOST_FINDINGS;
use crate::report::number::{self, NONE, significant};
use crate::report::section::brief::Brief;

/// A calibration in brief.
pub(in crate::report::section) struct Calibration;

impl Brief for Calibration {
    type Kind = Kind;

    /// Whether to believe it, what stands against it, and the evidence.
    fn headline(output: &Output) -> Vec<String> {
        let mut lines = Vec::new();
        if output.converged {
            let evidence = output.log_evidence.value.zip(output.log_evidence.sd);
            let evidence = evidence.map_or("is not known".to_owned(), |(value, sd)| number::with_error(value, sd));
            lines.push(format!("{} converged; logarithm of the evidence {evidence}", output.sampler));
        } else {
            lines.push(format!("{} did NOT converge", output.sampler));
            lines.extend(output.objections.iter().take(MOST_FINDINGS).cloned());
        }
        lines.extend(output.findings.iter().take(MOST_FINDINGS).cloned());
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let summaries = output.order.iter().filter_map(|name| Some((name, output.parameters.get(name)?)));
        let mut rows: Vec<(String, String)> = summaries
            .map(|(name, summary)| {
                let unit = if summary.unit == "1" { String::new() } else { format!(" {}", summary.unit) };
                (name.clone(), format!("{}{unit}", number::with_error(summary.mean, summary.sd)))
            })
            .collect();
        let evidence = output.log_evidence.value.map_or_else(|| NONE.to_owned(), |value| significant(value, 5));
        rows.push(("log evidence".to_owned(), evidence));
        rows.push(("converged".to_owned(), if output.converged { "yes" } else { "no" }.to_owned()));
        rows
    }
}
