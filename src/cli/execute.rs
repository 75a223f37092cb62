//! Running the jobs of passes with progress, event log and interruption: what every computing verb does.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use super::Context;
use super::options::{CacheOption, RunOptions};
use super::output::tell;
use super::status::{Failure, Status};
use super::studies::{self, Loaded, LoadedPass};
use crate::runner::engine::local;
use crate::runner::plan::State;
use crate::runner::{Cache, EventLog, Finished, Listener, Plan, Progress, RunSummary, Settings, WorkHistory};
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
    /// Whether it was interrupted.
    pub is_interrupted: bool,
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
        if self.is_interrupted {
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

/// Passes with their plan, of which nothing has run yet.
pub struct Prepared {
    passes: Vec<LoadedPass>,
    parents: Vec<LoadedPass>,
    plan: Plan,
    /// Ids of the wanted jobs.
    only: BTreeSet<String>,
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
    prepare(loaded, parents, context, wanted)?.run(options, context)
}

/// Plans the wanted jobs of passes that are loaded, and tells what is wrong with some of them; of `parents` the jobs by
/// which passes are judged are wanted.
///
/// # Errors
/// Jobs that build upon one another in a circle, and the like.
pub fn prepare(
    loaded: Loaded,
    parents: Loaded,
    context: &Context,
    wanted: impl Fn(&Pass, &str, &str) -> bool,
) -> Result<Prepared, Failure> {
    studies::tell_notes(&loaded.notes);
    let Loaded { mut passes, mut nodes, .. } = loaded;
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
    Ok(Prepared { passes, parents: older, plan, only })
}

/// A wanted job that has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotThere {
    /// Its pass, as people see it.
    pub pass: String,
    /// Its name.
    pub job: String,
}

impl Prepared {
    /// The cache of its passes.
    pub fn cache(&self, option: &CacheOption) -> Cache {
        option.cache(&self.passes)
    }

    /// Leaves out the wanted jobs that have no result in the cache, so that nothing runs.
    pub fn leave_out_missing(&mut self, cache: &Cache) -> Vec<NotThere> {
        let (states, _) = self.plan.survey(cache, Some(&self.only), false);
        let missing: BTreeSet<&String> = (self.plan.nodes().iter().zip(&states))
            .filter(|(_, state)| **state == State::Missing)
            .map(|(node, _)| &node.id)
            .collect();
        let mut left_out = Vec::new();
        for pass in &mut self.passes {
            let (gone, kept) = std::mem::take(&mut pass.jobs).into_iter().partition(|id| missing.contains(id));
            pass.jobs = kept;
            let gone: Vec<String> = gone;
            let name = |id: &String| self.plan.find(id).map(|position| self.plan.nodes()[position].name.clone());
            left_out.extend(gone.iter().filter_map(|id| Some(NotThere { pass: pass.shown.clone(), job: name(id)? })));
        }
        for pass in &mut self.parents {
            pass.jobs.retain(|id| !missing.contains(id));
        }
        self.only.retain(|id| !missing.contains(id));
        left_out
    }

    /// Lets comparisons whose calibration has no result in the cache show the model as delivered; gives their names and
    /// those of the calibrations.
    ///
    /// # Errors
    /// Jobs that build upon one another in a circle, and the like.
    pub fn deliver(self, cache: &Cache) -> Result<(Self, Vec<(String, String)>), Failure> {
        let (states, _) = self.plan.survey(cache, Some(&self.only), false);
        let waits = |position: usize| {
            let mut upstream = self.plan.upstream(position).iter();
            upstream.any(|&other| states[other] == State::Missing)
        };
        let waiting: Vec<usize> = (0..states.len())
            .filter(|&at| self.only.contains(&self.plan.nodes()[at].id) && states[at] == State::Missing && waits(at))
            .collect();
        let Self { passes, parents, plan, only } = self;
        let mut nodes = plan.into_nodes();
        let mut told = Vec::new();
        for position in waiting {
            let Some(pass) = passes.iter().find(|pass| pass.jobs.contains(&nodes[position].id)) else { continue };
            if let Some((node, calibration)) = studies::delivered(pass, &nodes[position].name) {
                told.push((node.name.clone(), calibration));
                nodes[position] = node;
            }
        }
        Ok((Self { passes, parents, plan: Plan::new(nodes)?, only }, told))
    }

    /// Runs what is wanted and not in the cache.
    ///
    /// # Errors
    /// A job that needs more memory than the machine has; a refusal of the system. What goes wrong with a job is in the
    /// summary.
    pub fn run(self, options: &RunOptions, context: &Context) -> Result<Executed, Failure> {
        let Self { passes, parents, plan, only } = self;
        let settings = Settings { only: Some(only), ..options.settings() };
        if let Some(note) = options.cache.shared(&passes) {
            tell(&note);
        }
        let cache = options.cache.cache(&passes);
        let needed = plan.preview(&cache, settings.only.as_ref(), settings.force, &WorkHistory::default());
        super::memory::check(&needed)?;
        let progress = Progress::on_standard_error();
        let log = EventLog::create(&options.cache.events(&passes));
        let run = |listener: &dyn Listener| {
            context.interrupts.during(|stop| local::run(&plan, &cache, &settings, stop, listener))
        };
        let summary = match &log {
            Ok(log) => run(&[&progress as &dyn Listener, log])?,
            Err(error) => {
                tell(&format!("warning: no event log: {error}"));
                run(&progress)?
            }
        };
        // One that comes with the last block counts too.
        let is_interrupted = summary.is_interrupted() || context.interrupts.is_stopped();
        Ok(Executed { passes, parents, plan, summary, is_interrupted })
    }
}
