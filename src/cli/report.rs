//! `bmv report`.

use std::path::PathBuf;

use super::execute::execute_loaded;
use super::options::{PathsArgument, RequireOption, RunOptions};
use super::output::{escaped, print, tell};
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
    require: RequireOption,
    #[command(flatten)]
    options: RunOptions,
}

impl Report {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let loaded = studies::load(&self.paths.paths, context.coloured)?;
        // A report shows what became of the error since the first pass.
        let parents = studies::parents(&loaded.passes);
        let executed = execute_loaded(loaded, parents, &self.options, context, |_, _, _| true)?;
        if executed.is_interrupted {
            return Ok(Status::Interrupted);
        }
        for pass in &executed.passes {
            match super::archive::render(pass, &executed, &self.out)? {
                Some(folder) => print(&format!("{}\n", folder.join("report.html").display()))?,
                None => tell(&format!("{}: no job has a result, no report", escaped(&pass.shown))),
            }
        }
        for (pass, job) in executed.not_converged() {
            tell(&format!("warning: {}:{job}: the sampler did not converge", escaped(&pass.shown)));
        }
        self.require.judge(&executed, executed.status())
    }
}
