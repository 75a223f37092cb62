//! `bmv verify`.

use std::path::{Path, PathBuf};

use super::output::{escaped, print, print_json, shown};
use super::status::{Failure, Status};
use crate::document::counted;
use crate::report::seal::contradictions;
use crate::runner::Manifest;
use crate::study::project::{missing, whole};

/// Arguments of `bmv verify`.
#[derive(Debug, clap::Args)]
pub(super) struct Verify {
    /// Folder of a report
    report: PathBuf,
    /// Folder of the project to which the inputs' paths belong [default: where they are found, from the report upwards,
    /// then from the working folder upwards]
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        if !self.report.exists() {
            return Err(Failure::input(missing(&self.report)));
        }
        let manifest = Manifest::read(&self.report).map_err(|error| Failure::input(error.to_string()))?;
        let root = self.root.clone().unwrap_or_else(|| root(&manifest, &self.report));
        let mut verification = manifest.verify(&self.report, &root)?;
        verification.contradictions = contradictions(&manifest, &self.report)
            .map_err(|error| Failure::input(format!("`{}` cannot be read: {error}", shown(&self.report))))?;
        let status = if verification.is_intact() { Status::Done } else { Status::CheckFailed };
        if self.json {
            print_json(&verification)?;
            return Ok(status);
        }
        let lists = [
            ("changed", &verification.changed),
            ("missing", &verification.missing),
            ("extra", &verification.extra),
            ("contradiction", &verification.contradictions),
            ("input changed", &verification.changed_inputs),
            ("input not here", &verification.missing_inputs),
        ];
        let mut text = String::new();
        for (what, names) in lists {
            text.extend(names.iter().map(|name| format!("{what}: {}\n", escaped(name))));
        }
        if let Some((theirs, ours)) = verification.other_engine {
            text.push_str(&format!(
                "made by numeric engine {theirs}, this is {ours}: a new run may give other numbers\n"
            ));
        }
        let verdict =
            if verification.is_intact() { "the report is as it was written" } else { "the report was altered" };
        print(&format!("{text}{} unchanged; {verdict}\n", counted(verification.unchanged, "file")))?;
        Ok(status)
    }
}

/// The nearest folder above the report, else the nearest from the working folder upwards, below which an input lies;
/// where there is none, the working folder.
fn root(manifest: &Manifest, report: &Path) -> PathBuf {
    let (report, here) = (whole(report), whole(Path::new("")));
    let holds = |folder: &&Path| manifest.inputs.keys().any(|input| folder.join(input).symlink_metadata().is_ok());
    let holding_folder = report.ancestors().skip(1).chain(here.ancestors()).find(holds);
    holding_folder.unwrap_or(&here).to_owned()
}
