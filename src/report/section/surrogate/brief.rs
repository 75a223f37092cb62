//! A surrogate in brief.

use crate::job::surrogate::{Kind, Output};
use crate::report::number::{significant, with_unit};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::in_a_line;

/// A surrogate in brief.
pub(in crate::report::section) struct Surrogate;

impl Brief for Surrogate {
    type Kind = Kind;

    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        std::iter::once(in_a_line(output).replace('`', "")).chain(output.findings.iter().cloned()).collect()
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let runs = ("runs of the model".to_owned(), output.runs.to_string());
        let errors = output.outputs.iter().map(|own| {
            (format!("cross-validated error of {}", own.output), with_unit(&significant(own.error, 2), &own.unit))
        });
        std::iter::once(runs).chain(errors).collect()
    }
}
