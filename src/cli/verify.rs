//! `bmv verify`.

use std::path::PathBuf;

use super::output::{escaped, print, print_json};
use super::status::{Failure, Status};
use crate::runner::Manifest;

/// Arguments of `bmv verify`.
#[derive(Debug, clap::Args)]
pub(super) struct Verify {
    /// Folder of a report
    report: PathBuf,
    /// Folder from which the report's command was run
    #[arg(long, value_name = "DIR", default_value = ".")]
    root: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let manifest = Manifest::read(&self.report).map_err(|error| Failure::input(error.to_string()))?;
        let found = manifest.verify(&self.report, &self.root)?;
        let status = if found.is_intact() { Status::Done } else { Status::CheckFailed };
        if self.json {
            print_json(&found)?;
            return Ok(status);
        }
        let lists = [
            ("changed", &found.changed),
            ("missing", &found.missing),
            ("extra", &found.extra),
            ("input changed", &found.changed_inputs),
            ("input not here", &found.missing_inputs),
        ];
        let mut text = String::new();
        for (what, names) in lists {
            text.extend(names.iter().map(|name| format!("{what}: {}\n", escaped(name))));
        }
        if let Some((theirs, ours)) = found.other_engine {
            text.push_str(&format!(
                "made by numeric engine {theirs}, this is {ours}: a new run may give other numbers\n"
            ));
        }
        let verdict = if found.is_intact() { "the report is as it was written" } else { "the report was altered" };
        print(&format!("{text}{} files unchanged; {verdict}\n", found.unchanged))?;
        Ok(status)
    }
}
