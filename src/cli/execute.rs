//! Running the jobs of passes with progress, event log and interruption: what every computing verb does.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use super::Context;
use super::options::RunOptions;
use super::output::tell;
use super::status::{Failure, Status};
use super::studies::{self, Loaded, LoadedPass};
use crate::runner::engine::local;
use crate::runner::{EventLog, Finished, Listener, Plan, Progress, RunSummary, Settings};
use crate::study::Pass;
use crate::study::history::judged_by;

/// Passes whose jobs were run.
pub struct Executed {
    /// The passes that were asked for.
    pub passes: Vec<LoadedPass>,
    /// Their parents, where those were wanted too.
    pub parents: Vec<LoadedPass>,
    /// All jobs.
    pub plan: Plan,
    /// What became of them.
    pub summary: RunSummary,
}

impl Executed {
    /// Results of a pass's wanted jobs: position in the plan, and the finished job.
    pub fn results<'e>(&'e self, pass: &'e LoadedPass) -> impl Iterator<Item = (usize, &'e Finished)> {
        pass.jobs.iter().filter_map(|id| Some((self.plan.find(id)?, self.summary.finished(id)?)))
    }

    /// As [`Executed::status`], where the wanted jobs are all that the command is for: that none could run, because
    /// data are not here, is then no success.
    pub fn status_of_wanted(&self) -> Status {
        match self.status() {
            Status::Done if self.passes.iter().all(|pass| pass.jobs.is_empty() && !pass.not_run.is_empty()) => {
                Status::WrongInput
            }
            status => status,
        }
    }

    /// Passes and names of the jobs whose sampler did not converge.
    pub fn not_converged(&self) -> impl Iterator<Item = (&LoadedPass, &str)> {
        self.passes.iter().flat_map(move |pass| {
            let unconverged = self.results(pass).filter(|(_, job)| !is_converged(job));
            unconverged.map(move |(position, _)| (pass, self.plan.nodes()[position].name.as_str()))
        })
    }

    /// How the program ends after this run.
    pub fn status(&self) -> Status {
        if self.summary.is_interrupted() {
            Status::Interrupted
        } else if self.summary.failures() > 0 {
            Status::JobFailed
        } else if self.passes.iter().any(|pass| !pass.refused.is_empty()) {
            Status::WrongInput
        } else if self.not_converged().next().is_some() {
            Status::NotConverged
        } else {
            Status::Done
        }
    }
}

/// Whether a job is one of those by which its pass is judged.
pub fn is_judge(pass: &Pass, name: &str) -> bool {
    judged_by(pass).is_some_and(|judge| judge.comparison == name || judge.calibration == Some(name))
}

/// A sampler's result says whether it converged; other results do not speak of it.
fn is_converged(job: &Finished) -> bool {
    job.stored.value.get("converged").and_then(serde_json::Value::as_bool).unwrap_or(true)
}

/// Loads, plans and runs the wanted jobs of the passes under these paths; `wanted` sees kind and name.
///
/// # Errors
/// Wrong input, or a refusal of the system. What goes wrong with a job is in the summary.
pub fn execute(
    paths: &[PathBuf],
    options: &RunOptions,
    context: &Context,
    wanted: impl Fn(&str, &str) -> bool,
) -> Result<Executed, Failure> {
    let loaded = studies::load(paths, context.coloured)?;
    execute_loaded(loaded, Loaded::default(), options, context, |_, kind, name| wanted(kind, name))
}

/// As [`execute`], for passes that are loaded; of `parents` the jobs run by which passes are judged.
///
/// # Errors
/// As [`execute`].
pub fn execute_loaded(
    loaded: Loaded,
    parents: Loaded,
    options: &RunOptions,
    context: &Context,
    wanted: impl Fn(&Pass, &str, &str) -> bool,
) -> Result<Executed, Failure> {
    let Loaded { mut passes, mut nodes, notes } = loaded;
    for note in notes {
        tell(&note);
    }
    let Loaded { passes: mut older, nodes: of_older, .. } = parents;
    nodes.extend(of_older);
    let plan = Plan::new(nodes)?;
    let retain = |pass: &mut LoadedPass, wanted: &dyn Fn(&Pass, &str, &str) -> bool| {
        let definition = Arc::clone(&pass.pass);
        pass.jobs.retain(|id| {
            plan.find(id).is_some_and(|position| {
                let node = &plan.nodes()[position];
                wanted(&definition, node.task.kind(), &node.name)
            })
        });
        pass.refused.retain(|refused| wanted(&definition, &refused.kind, &refused.name));
    };
    for pass in &mut passes {
        retain(pass, &wanted);
    }
    studies::tell_refused(&passes, context.coloured);
    for pass in &mut older {
        retain(pass, &|pass, _, name| is_judge(pass, name));
    }
    let wanted_ids = passes.iter().chain(&older).flat_map(|pass| pass.jobs.iter().cloned());
    let only: BTreeSet<String> = wanted_ids.collect();
    let settings = Settings { only: Some(only), ..options.settings() };

    let stop = context.stop()?;
    let progress = Progress::on_standard_error();
    if let Some(note) = options.cache.shared(&passes) {
        tell(&note);
    }
    let cache = options.cache.cache(&passes);
    let log = EventLog::create(&options.cache.events(&passes));
    let summary = match &log {
        Ok(log) => {
            let listeners: [&dyn Listener; 2] = [&progress, log];
            local::run(&plan, &cache, &settings, &stop, &listeners)?
        }
        Err(error) => {
            tell(&format!("warning: no event log: {error}"));
            local::run(&plan, &cache, &settings, &stop, &progress)?
        }
    };
    Ok(Executed { passes, parents: older, plan, summary })
}
