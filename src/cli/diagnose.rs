//! `bmv diagnose`.

use std::path::PathBuf;

use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, studies};
use crate::report::section::DIAGNOSIS;
use crate::report::{JobResult, terminal};

/// Arguments of `bmv diagnose`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "With --json one document is printed: of several jobs of kind `diagnose` that of the first, in \
                        the order of the file; `bmv show PASS JOB --json` prints another."
)]
pub(super) struct Diagnose {
    /// Pass file
    pass: PathBuf,
    /// Print one JSON document in SI units
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl Diagnose {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        studies::one_pass(&self.pass)?;
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, |kind, _| kind == "diagnose")?;
        for pass in &executed.passes {
            if !pass.pass.jobs.iter().any(|job| job.spec.kind() == "diagnose") {
                return Err(Failure::input(format!(
                    "`{}` has no job of kind `diagnose`; write \"jobs\": {{\"missing\": {{\"diagnose\": {{}}}}}}",
                    pass.shown
                )));
            }
            let report = studies::view(pass, &executed)?;
            if self.json {
                let found = report.results.iter().find(|job| matches!(job.result, JobResult::Diagnose(_)));
                if let Some(job) = found {
                    print_json(&studies::document(job, true)?)?;
                }
                continue;
            }
            let sections: Vec<_> = DIAGNOSIS(&report).into_iter().collect();
            print(&terminal::render(&sections, context.layout))?;
            let selects = report.diagnoses().any(|(_, output)| !output.selected.is_empty());
            if selects {
                tell(&format!("next: bmv adopt {}", escaped(&pass.shown)));
            }
        }
        Ok(executed.status_of_wanted())
    }
}
