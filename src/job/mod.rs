//! Job kinds, a kind a file. A job is stages: each stage cuts its inputs into blocks, runs a block as a pure function
//! to bytes, and reduces the blocks in order to the next stage or to the output. Nothing here knows threads or files.

pub mod calibrate;
pub mod compare;
pub mod conventional;
pub mod design;
pub mod diagnose;
mod fault;
pub mod findings;
pub mod goal;
pub mod handed_on;
pub mod lab;
pub mod predict;
pub mod propagate;
pub mod requirement;
pub mod sensitivity;
pub mod stored;

use thiserror::Error;

/// What a job does next.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Run these blocks, then call [`Job::reduce`]. A block's input is all that it needs beside the job itself.
    Blocks {
        /// Name of the stage, part of each block's identity.
        stage: String,
        /// Input of each block: small and serialisable, so that a block can run on another machine.
        inputs: Vec<Vec<u8>>,
    },
    /// The result.
    Done(serde_json::Value),
}

/// Why a job failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum JobError {
    /// The job cannot give a result.
    #[error("{0}")]
    Failed(String),
    /// Stored bytes of a block or an upstream result do not have the form that this version writes.
    #[error("a stored block of stage `{stage}` is not readable: {reason}")]
    Unreadable {
        /// The stage.
        stage: String,
        /// What is wrong.
        reason: String,
    },
}

/// States that a block leaves on its way, so that one that was killed goes on from the last of them. They decide nothing: from
/// each of them the block gives the same bytes as from its input.
pub trait Parts {
    /// The state that was kept under this number.
    fn find(&self, part: u64) -> Option<Vec<u8>>;
    /// Whether a state is to be kept now: it takes time, and a block that is short needs none.
    fn is_due(&self) -> bool;
    /// Keeps the state of this number: a pure function of the job, the stage, the input and the number.
    fn keep(&self, part: u64, state: &[u8]);
}

/// Keeps nothing.
pub struct NoParts;

impl Parts for NoParts {
    fn find(&self, _part: u64) -> Option<Vec<u8>> {
        None
    }
    fn is_due(&self) -> bool {
        false
    }
    fn keep(&self, _part: u64, _state: &[u8]) {}
}

/// A job that is ready to run: everything resolved, nothing looked up later.
pub trait Job: Send + Sync {
    /// The kind, as in the pass file.
    fn kind(&self) -> &'static str;
    /// Raised when the same definition gives another result.
    fn algorithm_version(&self) -> u32;
    /// Everything that decides the result, beside the seed and the versions: resolved settings, model, parameters,
    /// hashes of the data. Named fields only; goes into the key in canonical form.
    fn identity(&self) -> serde_json::Value;
    /// The first step.
    fn begin(&self) -> Result<Step, JobError>;
    /// Runs one block: a pure function of the job, the stage and the input.
    fn block(&self, stage: &str, input: &[u8]) -> Result<Vec<u8>, JobError>;
    /// The same, for a block that takes long: it keeps its state now and then, and goes on from the last one that was kept.
    fn block_in_parts(&self, stage: &str, input: &[u8], _parts: &dyn Parts) -> Result<Vec<u8>, JobError> {
        self.block(stage, input)
    }
    /// About how much memory the job takes for what grows with its settings (samples, draws), bytes; 0 where none of it
    /// is long.
    fn memory_bytes(&self) -> u64 {
        0
    }
    /// Whether no other stage follows this one, as far as is known when it begins: for the time left, which is not told
    /// of stages that nobody has counted yet.
    fn is_last(&self, _stage: &str) -> bool {
        false
    }
    /// Takes the blocks' outputs, in order, to the next step.
    fn reduce(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError>;
    /// The same, where the outputs are not needed any more: a job with long ones gives their memory up on the way.
    fn reduce_owned(&self, stage: &str, inputs: &[Vec<u8>], outputs: Vec<Vec<u8>>) -> Result<Step, JobError> {
        self.reduce(stage, inputs, &outputs)
    }
}
