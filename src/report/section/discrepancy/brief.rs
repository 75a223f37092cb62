//! A discrepancy in brief.

use crate::job::discrepancy::{Kind, Output};
use crate::report::headline::MOST_FINDINGS;
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A discrepancy in brief.
pub(in crate::report::section) struct Discrepancy;

impl Brief for Discrepancy {
    type Kind = Kind;

    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines: Vec<String> =
            output.sensors.iter().map(|own| format!("{}: {}", own.sensor, own.law.words())).collect();
        lines.extend(output.findings.iter().take(MOST_FINDINGS).map(|finding| finding.replace('`', "")));
        if !output.converged {
            lines.push("the chains behind it did NOT converge".to_owned());
        }
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let mut rows: Vec<(String, String)> =
            output.sensors.iter().map(|own| (format!("law of {}", own.sensor), own.law.words().to_owned())).collect();
        let confounded: Vec<&str> =
            output.parameters.iter().filter(|own| own.is_confounded).map(|own| own.name.as_str()).collect();
        let text = if confounded.is_empty() { "none".to_owned() } else { confounded.join(", ") };
        rows.push(("confounded with it".to_owned(), text));
        rows
    }
}
