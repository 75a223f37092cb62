//! `bmv report`.

use std::path::PathBuf;

use super::Context;
use super::execute::execute_loaded;
use super::options::{PathsArgument, RequireOption, RunOptions};
use super::output::{self, escaped, shown, tell};
use super::status::{Failure, Status};
use crate::batch::{self, archive, index, print};

/// Arguments of `bmv report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
                  bmv report my-study\n  \
                  bmv report my-study/pass-2.json --out review\n  \
                  bmv report my-study --pdf review")]
pub(super) struct Report {
    #[command(flatten)]
    paths: PathsArgument,
    /// Folder below which each study and pass gets its own [default: reports of the study's project]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder into which each report is printed as STUDY-PASS.pdf too, by a Chromium or Chrome
    #[arg(long, value_name = "DIR")]
    pdf: Option<PathBuf>,
    #[command(flatten)]
    require: RequireOption,
    #[command(flatten)]
    options: RunOptions,
}

impl Report {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let loaded = batch::load(&self.paths.paths, &context.reading)?;
        let targets = archive::targets(&loaded.passes, self.out.as_deref())?;
        let browser = self.pdf.as_ref().map(|_| print::browser()).transpose()?;
        // A report shows what became of the error since the first pass.
        let parents = batch::parents(&loaded.passes, &context.reading);
        let executed = execute_loaded(loaded, parents, &self.options, context, |_, _, _| true)?;
        if executed.is_interrupted {
            return Ok(Status::Interrupted);
        }
        let mut rendered = Vec::new();
        for (pass, target) in executed.passes.iter().zip(&targets) {
            if archive::render(pass, &executed, target)? {
                let page = target.folder().join("report.html");
                output::print(&format!("{}\n", shown(&page)))?;
                rendered.push((page, target.printed()));
            } else {
                tell(&format!("{}: no job has a result, no report", escaped(&pass.shown)));
            }
        }
        for (pass, target) in executed.passes.iter().zip(&targets) {
            let missing = archive::missing_neighbours(pass, target);
            if !missing.is_empty() {
                let (shown, study) = (escaped(&pass.shown), shown(&pass.study));
                let names = escaped(&missing.join(" and "));
                tell(&format!("note: the report of {shown} links to {names}, not rendered yet: bmv report {study}"));
            }
        }
        let (pages, notes) = index::write(&targets)?;
        for note in notes {
            tell(&format!("note: {note}"));
        }
        for page in pages {
            tell(&format!("index: {}", shown(&page)));
        }
        if let (Some(browser), Some(folder)) = (&browser, &self.pdf) {
            for (page, name) in rendered {
                let to = folder.join(name);
                let printed = context.interrupts.during(|stop| print::pdf(browser, &page, &to, &|| stop.is_stopped()));
                if context.interrupts.is_stopped() {
                    return Ok(Status::Interrupted);
                }
                printed?;
                output::print(&format!("{}\n", shown(&to)))?;
            }
        }
        for (pass, job) in executed.not_converged() {
            tell(&format!("warning: {}:{job}: the sampler did not converge", escaped(&pass.shown)));
        }
        self.require.judge(&executed, Status::of(&executed))
    }
}
