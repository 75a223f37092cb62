//! A calibration in brief.

use crate::job::calibrate::{Kind, Output};
use crate::report::headline::MOST_FINDINGS;
use crate::report::number::{self, NONE, significant};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A calibration in brief.
pub(in crate::report::section) struct Calibration;

impl Brief for Calibration {
    type Kind = Kind;

    /// Whether to believe it, what stands against it, and the evidence.
    fn headline(job: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines = Vec::new();
        if output.converged {
            let evidence = super::evidence(&output.log_evidence).unwrap_or_else(|| "is not known".to_owned());
            lines.push(format!("{} converged; logarithm of the evidence {evidence}", output.sampler));
        } else {
            lines.push(format!("{} did NOT converge", output.sampler));
            lines.extend(output.objections.iter().take(MOST_FINDINGS).cloned());
            lines.extend(output.remedy().map(|remedy| format!("what mends it: {}", remedy.in_words(&job.name))));
        }
        lines.extend(output.findings.iter().take(MOST_FINDINGS).cloned());
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let mut rows: Vec<(String, String)> = super::shown(output)
            .map(|(name, summary)| {
                let (times, unit) = number::stated(&summary.unit, summary.size());
                let value = number::with_error(times * summary.mean, times * summary.sd);
                (name.clone(), if unit.is_empty() { value } else { format!("{value} {unit}") })
            })
            .collect();
        let is_trusted = if output.log_evidence.is_trusted() { "" } else { ", not to be trusted" };
        let evidence = output.log_evidence.value;
        let evidence = evidence.map_or_else(|| NONE.to_owned(), |value| significant(value, 5) + is_trusted);
        rows.push(("log evidence".to_owned(), evidence));
        rows.push(("converged".to_owned(), if output.converged { "yes" } else { "no" }.to_owned()));
        rows
    }
}
