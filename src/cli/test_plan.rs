//! `bmv test-plan`.

use std::path::{Path, PathBuf};

use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch;
use crate::document::visible::shell_word;
use crate::job::test_plan::{Kind, csv, measurement};
use crate::report::section::TEST_PLAN;
use crate::report::terminal;

/// The kind of the jobs.
const KIND: &str = "test-plan";

/// Arguments of `bmv test-plan`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The sheet has a row a phase with its set points and an empty cell a reading. Filled in and put into the study, it is a \
                  measurement of the next pass; the entry that reads it is printed."
)]
pub(super) struct TestPlanVerb {
    /// Pass file
    pass: PathBuf,
    /// Name of a job of kind `test-plan` [default: the first]
    #[arg(long, value_name = "NAME")]
    job: Option<String>,
    /// Write the data sheet to this file, which must not be there yet
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
    /// Print one JSON document in SI units
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl TestPlanVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let path = select::one_pass(&self.pass)?;
        let wanted = select::job_of_kind(&path, KIND, self.job.as_deref(), context.coloured)?;
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, |kind, name| {
            kind == KIND && name == wanted
        })?;
        for pass in &executed.passes {
            let report = batch::view(pass, &executed)?;
            let Some(entry) = report.results.iter().find(|entry| entry.name == wanted) else { continue };
            let Some(output) = entry.output_of::<Kind>() else { continue };
            if self.json {
                print_json(&batch::document(entry, true)?)?;
            } else {
                let sections: Vec<_> = TEST_PLAN(&report).into_iter().collect();
                print(&terminal::render(&sections, context.layout))?;
            }
            if let Some(file) = &self.sheet {
                write_new(file, &csv(output))?;
                let shown = file.display().to_string();
                let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                let entry = measurement(output, &format!("data/{name}"));
                tell(&escaped(&format!(
                    "wrote {}; filled in and put under data/ of the study, it is",
                    shell_word(&shown)
                )));
                tell(&escaped(&format!("\"measurements\": {{\"test\": {entry}}}")));
            }
        }
        Ok(Status::of_wanted(&executed))
    }
}

/// Writes a file that is not there yet: a sheet with readings in it is never overwritten.
fn write_new(file: &Path, text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let opened = std::fs::OpenOptions::new().write(true).create_new(true).open(file);
    opened
        .and_then(|mut opened| opened.write_all(text.as_bytes()))
        .map_err(|error| Failure::input(format!("cannot write `{}`: {error}", escaped(&file.display().to_string()))))
}
