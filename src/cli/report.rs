//! `bmv report`.

use std::path::PathBuf;

use super::Context;
use super::execute::execute_loaded;
use super::options::{PathsArgument, RequireOption, RunOptions};
use super::output::{escaped, print, shown, tell};
use super::status::{Failure, Status};
use crate::batch::{self, archive, index};

/// Arguments of `bmv report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
                  bmv report my-study\n  \
                  bmv report my-study/pass-2.json --out review")]
pub(super) struct Report {
    #[command(flatten)]
    paths: PathsArgument,
    /// Folder below which each study and pass gets its own [default: reports of the study's project]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    require: RequireOption,
    #[command(flatten)]
    options: RunOptions,
}

impl Report {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let loaded = batch::load(&self.paths.paths, &context.reading)?;
        let targets = archive::targets(&loaded.passes, self.out.as_deref())?;
        // A report shows what became of the error since the first pass.
        let parents = batch::parents(&loaded.passes, &context.reading);
        let executed = execute_loaded(loaded, parents, &self.options, context, |_, _, _| true)?;
        if executed.is_interrupted {
            return Ok(Status::Interrupted);
        }
        for (pass, target) in executed.passes.iter().zip(&targets) {
            if archive::render(pass, &executed, target)? {
                print(&format!("{}\n", shown(&target.folder().join("report.html"))))?;
            } else {
                tell(&format!("{}: no job has a result, no report", escaped(&pass.shown)));
            }
        }
        let (pages, notes) = index::write(&targets)?;
        for note in notes {
            tell(&format!("note: {note}"));
        }
        for page in pages {
            tell(&format!("index: {}", shown(&page)));
        }
        for (pass, job) in executed.not_converged() {
            tell(&format!("warning: {}:{job}: the sampler did not converge", escaped(&pass.shown)));
        }
        self.require.judge(&executed, Status::of(&executed))
    }
}
