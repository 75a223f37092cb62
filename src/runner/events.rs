//! What the runner tells while it works. The runner emits, listeners (progress, event log) consume; nothing that an event
//! says, times above all, is part of a result.

use serde::{Deserialize, Serialize};

use super::key::Key;
use crate::watch::Share;

/// Something happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// A run begins.
    RunStarted {
        /// Jobs that will run.
        to_run: usize,
        /// Jobs whose results are in the cache.
        cached: usize,
        /// Threads of the pool.
        threads: usize,
        /// Who computes the blocks, if not these threads.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        engine: Option<String>,
    },
    /// What a scheduler or the machines of a cluster did, for people.
    Cluster {
        /// In words.
        text: String,
    },
    /// A job's result was in the cache.
    JobCached {
        /// Id of the job.
        job: String,
        /// Its key.
        key: Key,
    },
    /// A job begins.
    JobStarted {
        /// Id of the job.
        job: String,
        /// Its kind.
        kind: String,
        /// Its key.
        key: Key,
    },
    /// A stage of a job begins.
    StageStarted {
        /// Id of the job.
        job: String,
        /// The stage.
        stage: String,
        /// Its number of blocks.
        blocks: usize,
        /// Whether no other stage follows.
        #[serde(default)]
        is_last: bool,
    },
    /// A block is there.
    BlockDone {
        /// Id of the job.
        job: String,
        /// The stage.
        stage: String,
        /// Position in the stage, from 0.
        index: usize,
        /// Whether it was in the cache.
        cached: bool,
    },
    /// A damaged object was found and will be computed again.
    Damaged {
        /// Name of the object.
        object: Key,
    },
    /// What was computed cannot be stored; the run goes on without. Reported once a run.
    NotStored {
        /// Why.
        reason: String,
    },
    /// A job has its result.
    JobFinished {
        /// Id of the job.
        job: String,
        /// Its kind.
        kind: String,
        /// Its key.
        key: Key,
        /// Blocks that were run.
        blocks_run: usize,
        /// Blocks that were in the cache.
        blocks_cached: usize,
        /// Time spent in the job's own code, summed over threads, seconds.
        work_s: f64,
    },
    /// A job failed.
    JobFailed {
        /// Id of the job.
        job: String,
        /// Why.
        reason: String,
    },
    /// A job did not run because one that it builds upon has no result.
    JobSkipped {
        /// Id of the job.
        job: String,
        /// Id of the other.
        upstream: String,
    },
    /// The run ends.
    RunFinished {
        /// Jobs with a result.
        finished: usize,
        /// Jobs that failed or were skipped.
        failed: usize,
        /// Whether it was interrupted.
        interrupted: bool,
    },
}

/// Hears events. Called from all threads of a run; must return soon and cannot fail.
pub trait Listener: Sync {
    /// Takes note.
    fn hear(&self, event: &Event);

    /// A block is run; `share` says how far it has come while it does.
    fn block_runs(&self, _job: &str, _index: usize, _share: &Share) {}
}

impl Listener for Vec<&dyn Listener> {
    fn hear(&self, event: &Event) {
        for listener in self {
            listener.hear(event);
        }
    }

    fn block_runs(&self, job: &str, index: usize, share: &Share) {
        for listener in self {
            listener.block_runs(job, index, share);
        }
    }
}
