//! `bmv plan`.

use super::options::{PathsArgument, RunOptions};
use super::output::{escaped, print, print_json, table, tell};
use super::status::{Failure, Status};
use super::{Context, execute};
use crate::batch;
use crate::batch::memory::{self, WORTH_TELLING, bytes_text};
use crate::document::counted;
use crate::document::suggest::listed;
use crate::runner::progress::duration_text;
use crate::runner::{Plan, WorkHistory};
use crate::study::resolve::influence;

/// Inputs that are named of those that a model does not use.
const NAMED: usize = 8;

/// Arguments of `bmv plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
                  bmv plan my-study")]
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
        let loaded = batch::load(&self.paths.paths, &context.reading)?;
        execute::tell_notes(&loaded.notes);
        execute::tell_refused(&loaded.passes, context.coloured);
        let is_refused = loaded.passes.iter().any(|pass| !pass.refused.is_empty());
        let status = if is_refused { Status::WrongInput } else { Status::Done };
        let (cache, events) = (self.options.cache.cache(&loaded.passes), self.options.cache.events(&loaded.passes));
        let plan = Plan::new(loaded.nodes)?;
        let settings = self.options.settings();
        let history = WorkHistory::read(&events);
        let lines = plan.preview(&cache, None, settings.force, &history);
        if self.json {
            print_json(&lines)?;
            return Ok(status);
        }
        let tells_memory = lines.iter().any(|line| line.memory_bytes >= WORTH_TELLING);
        let mut rows = vec![["job", "kind", "key", "state", "work"].map(str::to_owned).to_vec()];
        rows[0].extend(tells_memory.then(|| "memory".to_owned()));
        for line in &lines {
            let work = match line.work_s {
                _ if line.cached => String::new(),
                Some(work_s) if line.is_same_work => duration_text(work_s),
                Some(work_s) => format!("unknown ({} before it was changed)", duration_text(work_s)),
                None => "unknown".to_owned(),
            };
            let state = if line.cached { "cached" } else { "to run" };
            let mut row =
                vec![escaped(&line.job), line.kind.clone(), line.key.short().to_owned(), state.to_owned(), work];
            if tells_memory {
                let is_large = line.memory_bytes >= WORTH_TELLING;
                row.push(if is_large { bytes_text(line.memory_bytes) } else { String::new() });
            }
            rows.push(row);
        }
        let missing = || lines.iter().filter(|line| !line.cached);
        let to_run = missing().count();
        // Only of the very same definition is it known that it takes as long again.
        let work_times_s: Vec<f64> =
            missing().filter(|line| line.is_same_work).filter_map(|line| line.work_s).collect();
        let threads = settings.threads();
        let length = match (work_times_s.len(), to_run - work_times_s.len()) {
            (0, 0) => String::new(),
            (0, _) => "; how long they take is not known yet".to_owned(),
            (_, unknown) => {
                let least = duration_text(work_times_s.iter().sum::<f64>() / threads as f64);
                let more = if unknown > 0 { format!(", and {unknown} of unknown length") } else { String::new() };
                format!("; at least {least} on {}{more}", counted(threads, "thread"))
            }
        };
        print(&format!(
            "{}\n{to_run} of {} to run{length}\n",
            table(&rows, context.fold),
            counted(lines.len(), "job")
        ))?;
        for pass in &loaded.passes {
            let unused = influence::unused(&pass.pass);
            if !unused.is_empty() {
                let names = listed(unused, NAMED);
                tell(&format!(
                    "note: {}: no sensor reading depends on {names} in this model; a diagnosis looks there too for what is missing",
                    pass.shown
                ));
            }
        }
        memory::check(&lines)?;
        Ok(status)
    }
}
