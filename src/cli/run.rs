//! `bmv run`.

use super::Context;
use super::cluster::{self, ClusterOptions, Engine};
use super::execute::{execute, prepare};
use super::options::{PathsArgument, RequireOption, RunOptions};
use super::output::{escaped, folded, print};
use super::status::{Failure, Status};
use crate::batch::{self, Executed, Loaded, LoadedPass};
use crate::document::counted;
use crate::report::section::objection;
use crate::report::{headline, terminal};
use crate::runner::cluster::Mode;

/// Arguments of `bmv run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
                  bmv run my-study\n  \
                  bmv run my-study/pass-2.json --threads 4\n  \
                  bmv run my-study --require\n  \
                  bmv run my-study --engine slurm --partition long --time 00:30:00 -c 4")]
pub(super) struct Run {
    #[command(flatten)]
    paths: PathsArgument,
    /// Only jobs of this kind, and what they build upon; may be given more than once
    #[arg(long = "job", value_name = "KIND")]
    kinds: Vec<String>,
    #[command(flatten)]
    require: RequireOption,
    #[command(flatten)]
    options: RunOptions,
    /// Who computes; results do not depend on it
    #[arg(long, value_name = "ENGINE", default_value = "local")]
    engine: Engine,
    #[command(flatten)]
    cluster: ClusterOptions,
}

/// What came out, by pass and job, and where to look next; a line of passes of which nothing ran, where something did of others.
pub(super) fn outcome(executed: &Executed, fold: Option<usize>) -> Result<String, Failure> {
    let mut text = String::new();
    let is_unchanged =
        |pass: &LoadedPass| executed.results(pass).filter(|(_, job)| job.cached).count() == pass.jobs.len();
    let has_news = executed.passes.iter().any(|pass| !is_unchanged(pass));
    for pass in &executed.passes {
        let report = batch::view(pass, executed)?;
        if report.results.is_empty() {
            continue;
        }
        let shown = escaped(&pass.shown);
        if has_news && is_unchanged(pass) {
            let jobs = counted(report.results.len(), "job");
            text.push_str(&format!("\n{shown}: unchanged, {jobs} in the cache (bmv show {shown})\n"));
            continue;
        }
        text.push_str(&format!("\n{shown}\n"));
        for job in &report.results {
            for (position, line) in headline::headlines(job).iter().enumerate() {
                let line = terminal::plain(line);
                let line = if position == 0 { format!("{}: {line}", escaped(&job.name)) } else { line };
                // What follows stands below the job's name, and so do the lines that are broken.
                let lead = if position == 0 { "  " } else { "    " };
                text.push_str(&folded(lead, &line, fold));
            }
        }
        if let Some(objection) = objection(&report) {
            text.push_str(&folded("  ", &terminal::sentence(&objection), fold));
        }
        text.push_str(&format!("  look at it: bmv show {shown}, or bmv report {shown}\n"));
    }
    Ok(text.trim_start().to_owned())
}

impl Run {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let wanted = |kind: &str, _: &str| self.kinds.is_empty() || self.kinds.iter().any(|wanted| wanted == kind);
        let executed = match self.engine {
            Engine::Local => execute(&self.paths.paths, &self.options, context, wanted)?,
            Engine::Slurm => {
                let loaded = batch::load(&self.paths.paths, &context.reading)?;
                let prepared = prepare(loaded, Loaded::default(), context, |_, kind, name| wanted(kind, name))?;
                cluster::run(prepared, &self.options, &self.cluster, context)?
            }
        };
        if executed.passes.iter().all(|pass| pass.jobs.is_empty()) && !self.kinds.is_empty() {
            return Err(Failure::input(format!("no job of kind `{}`", self.kinds.join("`, `"))));
        }
        print(&outcome(&executed, context.fold)?)?;
        let is_left = self.engine == Engine::Slurm && self.cluster.mode() == Mode::Detach;
        self.require.judge(&executed, cluster::status(&executed, is_left))
    }
}
