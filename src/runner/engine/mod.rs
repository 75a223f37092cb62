//! Where jobs run. An engine runs the blocks of a plan's jobs anywhere, in any order, and reduces them in their order.

pub(in crate::runner) mod block;
pub mod elsewhere;
pub mod local;
pub mod pool;

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use super::error::RunnerError;
use super::key::{Key, block_key};
use super::stored::Stored;
use crate::document::hash::sha256;
use crate::job::Stage;

/// The name of the output of a stage's block in the cache; `owner` is the job's key.
pub(super) fn block_name(owner: &Key, stage: &Stage, index: usize) -> Key {
    block_key(owner, &stage.name, index, [stage.state.sha256(), sha256(&stage.inputs[index])])
}

/// Asks a run to stop: no block is begun, one that runs is left at its next look at the flag, and what was finished is
/// kept. Clones ask the same run.
pub use crate::watch::Flag as StopFlag;

/// How to run. Nothing here changes a result.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// Threads; nothing = as many as the machine has.
    pub threads: Option<NonZeroUsize>,
    /// Run the wanted jobs although their results are in the cache. What is computed anew is compared with it.
    pub force: bool,
    /// Ids of the wanted jobs; nothing = all.
    pub only: Option<BTreeSet<String>>,
    /// How long a block runs before it keeps its state, each time; nothing = a second.
    pub keep_every: Option<Duration>,
}

/// After this time a block keeps its state: what a kill costs at most, and hardly a cost itself.
const KEEP_EVERY: Duration = Duration::from_secs(1);

impl Settings {
    /// How long a block runs before it keeps its state.
    pub(super) fn keep_every(&self) -> Duration {
        self.keep_every.unwrap_or(KEEP_EVERY)
    }

    /// Number of threads that a run uses.
    pub fn threads(&self) -> usize {
        self.threads.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get)
    }
}

/// A job with its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// Its key.
    pub key: Key,
    /// Its result.
    pub stored: Stored,
    /// Whether the result was in the cache.
    pub cached: bool,
    /// Blocks that were run.
    pub blocks_run: usize,
    /// Blocks that were in the cache.
    pub blocks_cached: usize,
}

/// What became of a job.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It has its result.
    Finished(Finished),
    /// It failed.
    Failed(Arc<RunnerError>),
    /// It did not run, because the job of this id, on which it builds, has no result.
    Skipped {
        /// Id of the other job.
        upstream: String,
    },
    /// The run was interrupted before it had a result.
    Interrupted,
}

impl Outcome {
    /// The finished job, if it is one.
    pub fn finished(&self) -> Option<&Finished> {
        match self {
            Self::Finished(finished) => Some(finished),
            _ => None,
        }
    }
}

/// What became of a run.
#[derive(Clone, Debug, Default)]
pub struct RunSummary {
    /// The outcome of each job that was needed, by id.
    pub outcomes: BTreeMap<String, Outcome>,
}

impl RunSummary {
    /// The finished job of this id.
    pub fn finished(&self, id: &str) -> Option<&Finished> {
        self.outcomes.get(id).and_then(Outcome::finished)
    }

    /// Number of jobs that failed or were skipped.
    pub fn failures(&self) -> usize {
        self.outcomes.values().filter(|o| matches!(o, Outcome::Failed(_) | Outcome::Skipped { .. })).count()
    }

    /// Whether any job was interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.outcomes.values().any(|outcome| matches!(outcome, Outcome::Interrupted))
    }
}
