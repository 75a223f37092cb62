//! Job kinds, a kind a folder and a line in the list below. A job is stages: each cuts its work into blocks, runs a block as a pure function of the job,
//! the state and the block's input, and reduces the blocks in order to the next stage or to the output. Nothing here knows
//! threads or files.

pub mod array;
pub mod dataset;
pub mod fault;
pub mod key_number;
pub mod kind;
pub mod lab;
pub mod prior_ends;
pub mod ready;
pub mod runnable;
pub mod steady_model;
pub mod stored;

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::thermal::External;
use array::Array;
use kind::ErasedKind;
pub use kind::{kinds, load};
pub use ready::{delivered, ready};
pub use runnable::{Next, Runnable, Stage};
use stored::Block;

/// Declares the kinds: a module each, and the registry.
macro_rules! kinds {
    ($( $module:ident ),* $(,)?) => {
        $( pub mod $module; )*

        /// All kinds that run.
        pub static KINDS: &[&dyn ErasedKind] = &[$( &$module::Kind ),*];
    };
}

kinds! {
    propagate,
    sensitivity,
    goal,
    design,
    calibrate,
    compare,
    diagnose,
    discrepancy,
    predict,
    test_plan,
    correlate,
    conventional,
    margins_from_history,
    surrogate,
}

/// What a job does next.
#[derive(Debug)]
pub enum Step<J: Job> {
    /// Run these blocks, then call [`Job::reduce`].
    Blocks {
        /// Name of the stage, for people; part of each block's identity.
        stage: String,
        /// What is known so far: the same for all blocks of the stage.
        state: J::State,
        /// What each block is to do.
        inputs: Vec<J::Input>,
    },
    /// The result.
    Done(Box<J::Output>),
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

impl From<crate::study::posterior_prior::PosteriorError> for JobError {
    fn from(error: crate::study::posterior_prior::PosteriorError) -> Self {
        Self::Failed(error.to_string())
    }
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
    /// What [`Parts::share`] was given for these bytes, by whichever block of whichever job.
    fn shared(&self, of: &[u8]) -> Option<Vec<u8>>;
    /// Shares with all jobs what follows from these bytes alone.
    fn share(&self, of: &[u8], found: &[u8]);
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
    fn shared(&self, _of: &[u8]) -> Option<Vec<u8>> {
        None
    }
    fn share(&self, _of: &[u8], _found: &[u8]) {}
}

/// A job that is ready to run: everything resolved, nothing looked up later.
///
/// State, inputs and partial results cross between processes as bytes ([`Block`]); [`Runnable`] does that for every job.
pub trait Job: Send + Sync + Sized {
    /// What is known when a stage begins.
    type State: Block + Clone + Send + Sync + 'static;
    /// What a block is to do, beside the job and the state.
    type Input: Block;
    /// What a block found.
    type Partial: Block;
    /// The result.
    type Output: Serialize + DeserializeOwned;

    /// The kind, as in the pass file.
    fn kind(&self) -> &'static str;
    /// Raised when the same definition gives another result.
    fn algorithm_version(&self) -> u32;
    /// Everything that decides the result, beside the seed and the versions: resolved settings, model, parameters,
    /// hashes of the data. Named fields only; goes into the key in canonical form.
    fn identity(&self) -> serde_json::Value;
    /// The first step.
    ///
    /// # Errors
    /// A [`JobError`] where the job cannot begin.
    fn begin(&self) -> Result<Step<Self>, JobError>;
    /// Runs one block: a pure function of the job, the state and the input. One that takes long keeps a state of its own in
    /// `parts` now and then, and goes on from the last that was kept.
    ///
    /// # Errors
    /// A [`JobError`] where the block has no result.
    fn block(&self, state: &Self::State, input: Self::Input, parts: &dyn Parts) -> Result<Self::Partial, JobError>;
    /// Takes what the blocks of a stage found, in their order, to the next step.
    ///
    /// # Errors
    /// A [`JobError`] where the job cannot go on.
    fn reduce(&self, state: Self::State, blocks: Done<Self>) -> Result<Step<Self>, JobError>;
    /// The arrays of a result, each with a name, whose numbers stand beside its JSON.
    fn arrays(_output: &Self::Output) -> Vec<(String, Array)> {
        Vec::new()
    }
    /// About how much memory the job takes for what grows with its settings (samples, draws), bytes; 0 where none of it
    /// is long.
    fn memory_bytes(&self) -> u64 {
        0
    }
    /// What some blocks of a stage, not all, already say of the result: a line each, for people. They are part of nothing.
    fn so_far(&self, _blocks: Done<Self>) -> Vec<String> {
        Vec::new()
    }
    /// What it asks outside, where that answers for its model.
    fn external(&self) -> Option<&External> {
        None
    }
    /// Whether no other stage follows this one, as far as is known when it begins: for the time left, which is not
    /// stated of stages that nobody has counted yet.
    fn is_last(&self, _state: &Self::State) -> bool {
        false
    }
}

/// Numbers by case.
type ByCase = Vec<Vec<f64>>;

/// The blocks of a stage, each with what it found.
pub type Done<J> = Vec<(<J as Job>::Input, <J as Job>::Partial)>;
