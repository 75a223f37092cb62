//! `bmv plan`.

use super::options::{PathsArgument, RunOptions};
use super::output::{escaped, print, print_json, table};
use super::status::{Failure, Status};
use super::{Context, studies};
use crate::runner::progress::duration_text;
use crate::runner::{Plan, WorkHistory};

/// Arguments of `bmv plan`.
#[derive(Debug, clap::Args)]
pub(super) struct PlanVerb {
    #[command(flatten)]
    paths: PathsArgument,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl PlanVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let plan = Plan::new(studies::load(&self.paths.paths, context.coloured)?.nodes)?;
        let settings = self.options.settings();
        let history = WorkHistory::read(&self.options.cache.events());
        let lines = plan.preview(&self.options.cache.cache(), None, settings.force, &history);
        if self.json {
            print_json(&lines)?;
            return Ok(Status::Done);
        }
        let mut rows = vec![["job", "kind", "key", "state", "work"].map(str::to_owned).to_vec()];
        for line in &lines {
            let work = match line.work_s {
                _ if line.cached => String::new(),
                Some(work_s) => duration_text(work_s),
                None => "unknown".to_owned(),
            };
            let state = if line.cached { "cached" } else { "to run" };
            rows.push(vec![escaped(&line.job), line.kind.clone(), line.key.short().to_owned(), state.to_owned(), work]);
        }
        let known_s: f64 = lines.iter().filter_map(|line| line.work_s).sum();
        let unknown = lines.iter().filter(|line| line.work_s.is_none()).count();
        let to_run = lines.iter().filter(|line| !line.cached).count();
        let threads = settings.threads();
        print(&format!(
            "{}\n{to_run} of {} jobs to run; at least {} on {threads} threads{}\n",
            table(&rows),
            lines.len(),
            duration_text(known_s / threads as f64),
            if unknown > 0 { format!(", and {unknown} jobs of unknown length") } else { String::new() }
        ))?;
        Ok(Status::Done)
    }
}
