//! The plan: jobs, what each builds upon, their keys, and which of them must run.
//!
//! A job's key is known before anything runs: it is made of the job's own identity and its upstream jobs' keys, never of
//! their results.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde_json::Value;

use super::cache::{Cache, Kind, Lookup};
use super::error::RunnerError;
use super::event_log::WorkHistory;
use super::key::{ENGINE_VERSION, Key, KeyMaterial};
use super::stored::Stored;
use crate::job::{JobError, Runnable};
use crate::math::sort::sort_by_key;

/// A job that may need the results of others before it is ready.
pub trait Task: Send + Sync {
    /// The kind, as in the pass file.
    fn kind(&self) -> &'static str;
    /// Raised when the same definition gives another result.
    fn algorithm_version(&self) -> u32;
    /// Everything that decides the result beside seed, versions and upstream results, as [`Runnable::identity`].
    fn identity(&self) -> Value;
    /// As [`Runnable::memory_bytes`].
    fn memory_bytes(&self) -> u64 {
        0
    }
    /// Makes the job ready; `upstream` are the results of [`Node::from`], in that order.
    ///
    /// # Errors
    /// A [`JobError`] if the upstream results do not have what this job needs.
    fn prepare(&self, upstream: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError>;
}

/// A job that needs no other.
pub struct Ready(pub Arc<dyn Runnable>);

impl Task for Ready {
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    fn algorithm_version(&self) -> u32 {
        self.0.algorithm_version()
    }

    fn identity(&self) -> Value {
        self.0.identity()
    }

    fn memory_bytes(&self) -> u64 {
        self.0.memory_bytes()
    }

    fn prepare(&self, _upstream: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        Ok(Arc::clone(&self.0))
    }
}

/// A job as the runner is given it.
pub struct Node {
    /// What people call it, unique in a plan, as in `studies/tclab/pass-1.json:tuned`. Not part of the key.
    pub id: String,
    /// Name of the job in its pass: random streams are keyed by it.
    pub name: String,
    /// The study's seed.
    pub seed: u64,
    /// Ids of the jobs whose results it uses.
    pub from: Vec<String>,
    /// The job.
    pub task: Box<dyn Task>,
}

/// Jobs in an order in which each stands after those that it builds upon.
pub struct Plan {
    nodes: Vec<Node>,
    keys: Vec<Key>,
    upstream: Vec<Vec<usize>>,
}

/// What is to be done about a job.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Its result is in the cache.
    Cached(Stored),
    /// It must run.
    Missing,
    /// Nobody asked for it, and nothing that must run needs it.
    NotNeeded,
}

/// A line of `bmv plan`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Preview {
    /// Id of the job.
    pub job: String,
    /// Its kind.
    pub kind: String,
    /// Its key.
    pub key: Key,
    /// Whether its result is in the cache.
    pub cached: bool,
    /// Seconds of work on one thread by the last time it ran, where known; 0 if cached.
    pub work_s: Option<f64>,
    /// Whether that time is of this very definition, and not of another one of the same name.
    pub is_same_work: bool,
    /// Memory that it needs for its samples or draws, bytes; 0 where that does not matter, or if cached.
    pub memory_bytes: u64,
}

impl Plan {
    /// Orders the jobs and computes their keys.
    ///
    /// # Errors
    /// [`RunnerError::DuplicateJob`], [`RunnerError::UnknownUpstream`], [`RunnerError::Cycle`], or
    /// [`RunnerError::NotCanonical`] for an identity that cannot be hashed.
    pub fn new(nodes: Vec<Node>) -> Result<Self, RunnerError> {
        let mut positions = BTreeMap::new();
        for (position, node) in nodes.iter().enumerate() {
            if positions.insert(node.id.as_str(), position).is_some() {
                return Err(RunnerError::DuplicateJob { id: node.id.clone() });
            }
        }
        let mut upstream = Vec::with_capacity(nodes.len());
        for node in &nodes {
            let positions = node.from.iter().map(|id| {
                positions
                    .get(id.as_str())
                    .copied()
                    .ok_or_else(|| RunnerError::UnknownUpstream { id: node.id.clone(), upstream: id.clone() })
            });
            upstream.push(positions.collect::<Result<Vec<_>, _>>()?);
        }
        let order = order(&upstream)
            .map_err(|circle| RunnerError::Cycle { jobs: circle.iter().map(|&i| nodes[i].id.clone()).collect() })?;

        let mut new_position = vec![0; nodes.len()];
        for (new, &old) in order.iter().enumerate() {
            new_position[old] = new;
        }
        let mut nodes: Vec<_> = nodes.into_iter().zip(upstream).enumerate().collect();
        sort_by_key(&mut nodes, |(old, _)| new_position[*old]);
        let mut plan = Self { nodes: Vec::new(), keys: Vec::new(), upstream: Vec::new() };
        for (_, (node, upstream)) in nodes {
            let upstream: Vec<_> = upstream.iter().map(|&old| new_position[old]).collect();
            plan.keys.push(plan.material_of(&node, &upstream).key()?);
            plan.nodes.push(node);
            plan.upstream.push(upstream);
        }
        Ok(plan)
    }

    /// The jobs, each after those that it builds upon; otherwise in the order in which they were given.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Keys of the jobs, in the order of [`Plan::nodes`].
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Positions in [`Plan::nodes`] of the jobs that this one builds upon.
    pub fn upstream(&self, position: usize) -> &[usize] {
        &self.upstream[position]
    }

    /// The jobs, to be planned anew.
    pub fn into_nodes(self) -> Vec<Node> {
        self.nodes
    }

    /// Position of a job by its id, or by its name if only one job has that name.
    pub fn find(&self, id_or_name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.id == id_or_name).or_else(|| {
            let mut named = (0..self.nodes.len()).filter(|&position| self.nodes[position].name == id_or_name);
            named.next().filter(|_| named.next().is_none())
        })
    }

    /// What a job's key is made of.
    pub fn material(&self, position: usize) -> KeyMaterial {
        self.material_of(&self.nodes[position], &self.upstream[position])
    }

    fn material_of(&self, node: &Node, upstream: &[usize]) -> KeyMaterial {
        KeyMaterial {
            kind: node.task.kind().to_owned(),
            algorithm_version: node.task.algorithm_version(),
            engine_version: ENGINE_VERSION,
            seed: node.seed,
            name: node.name.clone(),
            identity: node.task.identity(),
            upstream: upstream.iter().map(|&position| self.keys[position].clone()).collect(),
        }
    }

    /// Looks every job up that is wanted (`only`: ids; nothing = all), and those that a missing one needs. With `force`
    /// the wanted ones count as missing. The second value names the damaged objects that were found.
    pub fn survey(&self, cache: &Cache, only: Option<&BTreeSet<String>>, force: bool) -> (Vec<State>, Vec<Key>) {
        let mut states = vec![State::NotNeeded; self.nodes.len()];
        let mut damaged = Vec::new();
        let mut needed = vec![false; self.nodes.len()];
        // Backwards, so that all that need a job were seen before it.
        for position in (0..self.nodes.len()).rev() {
            let is_wanted = only.is_none_or(|only| only.contains(&self.nodes[position].id));
            if !is_wanted && !needed[position] {
                continue;
            }
            states[position] = State::Missing;
            if !(force && is_wanted) {
                match cache.get(Kind::Result, &self.keys[position]) {
                    Lookup::Found(bytes) => {
                        if let Ok(stored) = Stored::from_bytes(&bytes, &self.nodes[position].id) {
                            states[position] = State::Cached(stored);
                            continue;
                        }
                    }
                    Lookup::Damaged => damaged.push(self.keys[position].clone()),
                    Lookup::Absent => {}
                }
            }
            for &upstream in &self.upstream[position] {
                needed[upstream] = true;
            }
        }
        (states, damaged)
    }

    /// What a run would do, in order; jobs that are not needed are left out.
    pub fn preview(
        &self,
        cache: &Cache,
        only: Option<&BTreeSet<String>>,
        force: bool,
        history: &WorkHistory,
    ) -> Vec<Preview> {
        let (states, _) = self.survey(cache, only, force);
        let lines = self.nodes.iter().zip(&self.keys).zip(states);
        lines
            .filter(|(_, state)| *state != State::NotNeeded)
            .map(|((node, key), state)| {
                let cached = matches!(state, State::Cached(_));
                let work_s = if cached { Some(0.0) } else { history.work_s(&node.id, key) };
                Preview {
                    job: node.id.clone(),
                    kind: node.task.kind().to_owned(),
                    key: key.clone(),
                    cached,
                    work_s,
                    is_same_work: cached || history.has(key),
                    memory_bytes: if cached { 0 } else { node.task.memory_bytes() },
                }
            })
            .collect()
    }
}

/// An order in which each stands after its upstream, close to the given one; or a circle.
pub fn order(upstream: &[Vec<usize>]) -> Result<Vec<usize>, Vec<usize>> {
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Open,
        Done,
    }
    let mut marks = vec![Mark::New; upstream.len()];
    let mut order = Vec::with_capacity(upstream.len());
    // An explicit stack of (job, next upstream to look at): a long chain must not end the program's own stack.
    for start in 0..upstream.len() {
        let mut path = Vec::new();
        if marks[start] == Mark::New {
            marks[start] = Mark::Open;
            path.push((start, 0));
        }
        while let Some((job, next)) = path.pop() {
            let Some(&needed) = upstream[job].get(next) else {
                marks[job] = Mark::Done;
                order.push(job);
                continue;
            };
            path.push((job, next + 1));
            match marks[needed] {
                Mark::Done => {}
                Mark::New => {
                    marks[needed] = Mark::Open;
                    path.push((needed, 0));
                }
                Mark::Open => {
                    let mut circle: Vec<_> =
                        path.iter().map(|&(job, _)| job).skip_while(|&job| job != needed).collect();
                    circle.push(needed);
                    return Err(circle);
                }
            }
        }
    }
    Ok(order)
}
