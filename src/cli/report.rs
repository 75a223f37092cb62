//! `bmv report`.

use std::path::PathBuf;

use super::execute::execute;
use super::options::{PathsArgument, RunOptions};
use super::output::tell;
use super::status::{Failure, Status};
use super::{Context, studies};

/// Arguments of `bmv report`.
#[derive(Debug, clap::Args)]
pub(super) struct Report {
    #[command(flatten)]
    paths: PathsArgument,
    /// Folder below which each study and pass gets its own
    #[arg(long, value_name = "DIR", default_value = "reports")]
    out: PathBuf,
    #[command(flatten)]
    options: RunOptions,
}

impl Report {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let executed = execute(&self.paths.paths, &self.options, context, |_, _| true)?;
        if executed.summary.is_interrupted() {
            return Ok(Status::Interrupted);
        }
        for pass in &executed.passes {
            let written = studies::render(pass, &executed.plan, &executed.summary, &self.out)?;
            for file in written {
                tell(&format!("wrote {}", file.display()));
            }
        }
        Ok(executed.status())
    }
}
