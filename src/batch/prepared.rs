//! Passes with a plan of their wanted jobs, of which nothing has run yet.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::cluster::job_name;
use super::executed::is_judge;
use super::graph::delivered;
use super::load::{Loaded, LoadedPass};
use super::{BatchError, Executed, memory};
use crate::runner::cluster::overview::{Overview, blocks_there};
use crate::runner::engine::elsewhere::Elsewhere;
use crate::runner::engine::local;
use crate::runner::interrupt::Interrupts;
use crate::runner::plan::State;
use crate::runner::{Cache, Key, Listener, Plan, RunSummary, RunnerError, Settings, StopFlag, WorkHistory};
use crate::study::Pass;

/// Passes with their plan, of which nothing has run yet.
pub struct Prepared {
    passes: Vec<LoadedPass>,
    parents: Vec<LoadedPass>,
    plan: Plan,
    /// Ids of the wanted jobs.
    only: BTreeSet<String>,
}

/// Plans the wanted jobs of passes that are loaded; of `parents` the jobs by which passes are judged are wanted.
///
/// # Errors
/// Jobs that build upon one another in a circle, and the like.
pub fn prepare(
    loaded: Loaded,
    parents: Loaded,
    wanted: impl Fn(&Pass, &str, &str) -> bool,
) -> Result<Prepared, BatchError> {
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
    /// How far it has come on a cluster.
    pub on_cluster: Option<Overview>,
    /// What it says so far there, a line each.
    pub so_far: Vec<String>,
}

impl Prepared {
    /// The passes that were asked for.
    pub fn passes(&self) -> &[LoadedPass] {
        &self.passes
    }

    /// Keys of the wanted jobs.
    pub fn wanted_keys(&self) -> Vec<&Key> {
        self.wanted().map(|position| &self.plan.keys()[position]).collect()
    }

    /// The wanted jobs, by their pass's file and their name.
    pub fn wanted_jobs(&self) -> Vec<String> {
        let of_pass = |pass: &LoadedPass| -> Vec<String> {
            let names = pass.jobs.iter().filter_map(|id| self.plan.find(id));
            names.map(|position| job_name(&pass.file, &self.plan.nodes()[position].name)).collect()
        };
        self.passes.iter().flat_map(of_pass).collect()
    }

    fn wanted(&self) -> impl Iterator<Item = usize> {
        (0..self.plan.nodes().len()).filter(|&position| self.only.contains(&self.plan.nodes()[position].id))
    }

    /// Keys of the wanted jobs of a pass and of those on which they build.
    pub fn keys_for(&self, pass: &LoadedPass) -> Vec<Key> {
        let mut positions: Vec<usize> = pass.jobs.iter().filter_map(|id| self.plan.find(id)).collect();
        let mut next = 0;
        while let Some(&position) = positions.get(next) {
            next += 1;
            for &upstream in self.plan.upstream(position) {
                if !positions.contains(&upstream) {
                    positions.push(upstream);
                }
            }
        }
        positions.into_iter().map(|position| self.plan.keys()[position].clone()).collect()
    }

    /// As [`Prepared::run_until`]; blocks that are not in the cache are computed elsewhere.
    ///
    /// # Errors
    /// As there, and what concerns all blocks elsewhere.
    pub fn run_elsewhere(
        self,
        settings: Settings,
        cache: &Cache,
        listener: &dyn Listener,
        elsewhere: &dyn Elsewhere,
    ) -> Result<Executed, BatchError> {
        // Who computes elsewhere decides when a run is left.
        self.run_by(settings, cache, |plan, settings| {
            local::run_elsewhere(plan, cache, settings, &StopFlag::default(), listener, elsewhere)
        })
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
            let not_there = |id: &String| {
                let position = self.plan.find(id)?;
                let node = &self.plan.nodes()[position];
                let on_cluster = blocks_there(cache, &self.plan.keys()[position]);
                // What builds on others says nothing before they are there, and what cannot be read says nothing.
                let job =
                    on_cluster.as_ref().filter(|_| node.from.is_empty()).and_then(|_| node.task.prepare(&[]).ok());
                let blocks = on_cluster.as_ref().map_or_else(Vec::new, |overview| overview.blocks.clone());
                let so_far = job.and_then(|job| job.so_far(blocks).ok()).unwrap_or_default();
                Some(NotThere { pass: pass.shown.clone(), job: node.name.clone(), on_cluster, so_far })
            };
            left_out.extend(gone.iter().filter_map(not_there));
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
    pub fn deliver(self, cache: &Cache) -> Result<(Self, Vec<(String, String)>), BatchError> {
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
        let mut without = Vec::new();
        for position in waiting {
            let Some(pass) = passes.iter().find(|pass| pass.jobs.contains(&nodes[position].id)) else { continue };
            if let Some((node, calibration)) = delivered(pass, &nodes[position].name) {
                without.push((node.name.clone(), calibration));
                nodes[position] = node;
            }
        }
        Ok((Self { passes, parents, plan: Plan::new(nodes)?, only }, without))
    }

    /// What jobs that would run take of memory, where that is much: a line each.
    pub fn memory_notes(&self, cache: &Cache, force: bool) -> Vec<String> {
        memory::notes(&self.plan.preview(cache, Some(&self.only), force, &WorkHistory::default()))
    }

    /// Runs what is wanted and not in the cache; Ctrl-C stops it.
    ///
    /// # Errors
    /// As [`Prepared::run_until`].
    pub fn run(
        self,
        settings: Settings,
        cache: &Cache,
        interrupts: &Interrupts,
        listener: &dyn Listener,
    ) -> Result<Executed, BatchError> {
        let mut executed = interrupts.during(|stop| self.run_until(settings, cache, stop, listener))?;
        // One that comes with the last block counts too.
        executed.is_interrupted |= interrupts.is_stopped();
        Ok(executed)
    }

    /// Runs what is wanted and not in the cache, until that is done or the flag is raised.
    ///
    /// # Errors
    /// A job that needs more memory than the machine has; a refusal of the system. What goes wrong with a job is in the
    /// summary.
    pub fn run_until(
        self,
        settings: Settings,
        cache: &Cache,
        stop: &StopFlag,
        listener: &dyn Listener,
    ) -> Result<Executed, BatchError> {
        self.run_by(settings, cache, |plan, settings| local::run(plan, cache, settings, stop, listener))
    }

    fn run_by(
        self,
        settings: Settings,
        cache: &Cache,
        run: impl FnOnce(&Plan, &Settings) -> Result<RunSummary, RunnerError>,
    ) -> Result<Executed, BatchError> {
        let Self { passes, parents, plan, only } = self;
        let settings = Settings { only: Some(only), ..settings };
        let needed = plan.preview(cache, settings.only.as_ref(), settings.force, &WorkHistory::default());
        memory::check(&needed)?;
        let summary = run(&plan, &settings)?;
        let is_interrupted = summary.is_interrupted();
        Ok(Executed { passes, parents, plan, summary, is_interrupted })
    }
}
