//! `bmv verify`.

use std::path::{Path, PathBuf};

use super::output::{escaped, print, print_json, shown};
use super::status::{Failure, Status};
use crate::document::counted;
use crate::report::archive;
use crate::report::seal::contradictions;
use crate::runner::Manifest;
use crate::runner::manifest::Verification;
use crate::study::project::{missing, whole};

/// Arguments of `bmv verify`.
#[derive(Debug, clap::Args)]
pub(super) struct Verify {
    /// Folder of a report, of a study's reports, or of all reports
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
        let mut reports = archive::reports_below(&self.report);
        // A report by itself is held against nothing round it.
        reports.retain(|folder| *folder != self.report);
        let (mut status, mut text) = (Status::Done, String::new());
        let mut documents = serde_json::Map::new();
        for folder in if reports.is_empty() { vec![self.report.clone()] } else { reports.clone() } {
            let verification = self.verification(&folder)?;
            if !verification.is_intact() {
                status = Status::CheckFailed;
            }
            if folder != self.report {
                text.push_str(&format!("{}: ", shown(&folder)));
            }
            text.push_str(&in_words(&verification));
            let document = serde_json::to_value(&verification).map_err(|error| Failure::job(error.to_string()))?;
            documents.insert(folder.display().to_string(), document);
        }
        let mut altered = archive::ro_crate::contradictions(&reports).map_err(unreadable(&self.report))?;
        altered.extend(archive::altered_pages(&self.report, &reports).map_err(unreadable(&self.report))?);
        if !altered.is_empty() {
            status = Status::CheckFailed;
        }
        if !self.json {
            text.extend(altered.iter().map(|what| format!("contradiction: {}\n", escaped(what))));
            print(&text)?;
        } else if let Some(document) = documents.remove(&self.report.display().to_string()) {
            print_json(&document)?;
        } else {
            print_json(&serde_json::json!({ "reports": documents, "contradictions": altered }))?;
        }
        Ok(status)
    }

    /// What of a report is not as it was written.
    fn verification(&self, folder: &Path) -> Result<Verification, Failure> {
        let manifest = Manifest::read(folder).map_err(|error| Failure::input(error.to_string()))?;
        let root = self.root.clone().unwrap_or_else(|| root(&manifest, folder));
        let mut verification = manifest.verify(folder, &root)?;
        verification.contradictions = contradictions(&manifest, folder).map_err(unreadable(folder))?;
        Ok(verification)
    }
}

fn unreadable(folder: &Path) -> impl Fn(std::io::Error) -> Failure {
    move |error| Failure::input(format!("`{}` cannot be read: {error}", shown(folder)))
}

/// What was found, a line each, and the verdict.
fn in_words(verification: &Verification) -> String {
    let lists = [
        ("output changed", &verification.changed),
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
        text.push_str(&format!("made by numeric engine {theirs}, this is {ours}: a new run may give other numbers\n"));
    }
    let of_report = [&verification.changed, &verification.missing, &verification.extra, &verification.contradictions];
    let verdict = match (of_report.iter().all(|list| list.is_empty()), verification.changed_inputs.is_empty()) {
        (true, true) => "the report is as it was written",
        (true, false) => "the report is as it was written, and its inputs are others now",
        (false, _) => "the report was altered",
    };
    format!("{text}{} unchanged; {verdict}\n", counted(verification.unchanged, "file"))
}

/// The nearest folder above the report, else the nearest from the working folder upwards, below which an input lies;
/// where there is none, the working folder.
fn root(manifest: &Manifest, report: &Path) -> PathBuf {
    let (report, here) = (whole(report), whole(Path::new("")));
    let holds = |folder: &&Path| manifest.inputs.keys().any(|input| folder.join(input).symlink_metadata().is_ok());
    let holding_folder = report.ancestors().skip(1).chain(here.ancestors()).find(holds);
    holding_folder.unwrap_or(&here).to_owned()
}
