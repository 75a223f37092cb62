//! Jobs of any kind as the runner sees them: what crosses between stages as bytes.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, OnceLock};

use serde_json::Value;

use super::stored::{self, Block, ResultDocument, unreadable};
use super::{Done, Job, JobError, Parts, Step};
use crate::document::hash::sha256;
use crate::thermal::External;

/// What a stage is called of which not all blocks are there.
const SO_FAR: &str = "so far";

/// What is known when a stage begins, as bytes and as read back from them.
#[derive(Clone)]
pub struct State {
    bytes: Vec<u8>,
    /// Found when it is asked for: every block of a stage has it in its name, and a state may be long.
    sha256: OnceLock<[u8; 32]>,
    value: Arc<dyn Any + Send + Sync>,
}

impl State {
    fn new<T: Block + Send + Sync + 'static>(state: T, stage: &str) -> Result<Self, JobError> {
        let bytes = state.into_bytes()?;
        // As another machine would read it, so that nothing lives in memory alone.
        let value = Arc::new(T::from_bytes(&bytes, stage)?);
        Ok(Self::of(bytes, value))
    }

    fn of(bytes: Vec<u8>, value: Arc<dyn Any + Send + Sync>) -> Self {
        Self { bytes, sha256: OnceLock::new(), value }
    }

    fn get<T: 'static>(&self, stage: &str) -> Result<&T, JobError> {
        self.value.downcast_ref().ok_or_else(|| unreadable(stage, "its state is another job's"))
    }

    /// The stored form, part of each block's identity.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// SHA-256 of that.
    pub fn sha256(&self) -> [u8; 32] {
        *self.sha256.get_or_init(|| sha256(&self.bytes))
    }
}

impl fmt::Debug for State {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} bytes", self.bytes.len())
    }
}

/// Blocks that can run side by side, on any machine that has the job.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Name, for people; part of each block's identity.
    pub name: String,
    /// What is known so far.
    pub state: State,
    /// What each block is to do.
    pub inputs: Vec<Vec<u8>>,
    /// Whether no other stage follows, as far as is known.
    pub is_last: bool,
}

/// What follows a stage.
#[derive(Clone, Debug)]
pub enum Next {
    /// Another stage.
    Stage(Stage),
    /// The result.
    Done(ResultDocument),
}

/// A job of any kind. Every [`Job`] is one.
pub trait Runnable: Send + Sync {
    /// As [`Job::kind`].
    fn kind(&self) -> &'static str;
    /// As [`Job::algorithm_version`].
    fn algorithm_version(&self) -> u32;
    /// As [`Job::identity`].
    fn identity(&self) -> Value;
    /// As [`Job::memory_bytes`].
    fn memory_bytes(&self) -> u64;
    /// Whether something outside answers for its model, so that what fails at one machine may succeed at another.
    fn is_external(&self) -> bool;
    /// A stage as another process has written it down: its name, its state, the inputs of its blocks.
    ///
    /// # Errors
    /// A state that cannot be read.
    fn stage(&self, name: &str, state: Vec<u8>, inputs: Vec<Vec<u8>>) -> Result<Stage, JobError>;
    /// As [`Job::begin`].
    ///
    /// # Errors
    /// What the job gives; a state or an input that cannot be written.
    fn begin(&self) -> Result<Next, JobError>;
    /// The stored result of a block of a stage, by its index.
    ///
    /// # Errors
    /// What the job gives; bytes that cannot be read or written.
    fn block(&self, stage: &Stage, index: usize, parts: &dyn Parts) -> Result<Vec<u8>, JobError>;
    /// Takes the stored results of all blocks of a stage, in order, to what follows.
    ///
    /// # Errors
    /// What the job gives; bytes that cannot be read or written.
    fn reduce(&self, stage: &Stage, outputs: Vec<Vec<u8>>) -> Result<Next, JobError>;
    /// As [`Job::so_far`], of stored inputs and results of blocks.
    ///
    /// # Errors
    /// Bytes that cannot be read.
    fn so_far(&self, blocks: Vec<(Vec<u8>, Vec<u8>)>) -> Result<Vec<String>, JobError>;
    /// The job itself, for what only its kind can say.
    fn as_any(&self) -> &dyn Any;
}

/// The blocks of a stage as the job reads them: the input of each, and what it gave. Bytes go as they are read, so that
/// long results are in memory once.
///
/// # Errors
/// [`JobError::Unreadable`] for bytes of another form, or not as many outputs as inputs.
pub fn blocks<J: Job>(stage: &Stage, outputs: Vec<Vec<u8>>) -> Result<Done<J>, JobError> {
    let name = &stage.name;
    if outputs.len() != stage.inputs.len() {
        return Err(unreadable(name, "it has not one result for each block"));
    }
    let read = |(input, output): (&Vec<u8>, Vec<u8>)| -> Result<_, JobError> {
        Ok((J::Input::from_bytes(input, name)?, J::Partial::from_bytes(&output, name)?))
    };
    stage.inputs.iter().zip(outputs).map(read).collect()
}

impl<J: Job + 'static> Runnable for J {
    fn kind(&self) -> &'static str {
        Job::kind(self)
    }

    fn algorithm_version(&self) -> u32 {
        Job::algorithm_version(self)
    }

    fn identity(&self) -> Value {
        Job::identity(self)
    }

    fn memory_bytes(&self) -> u64 {
        Job::memory_bytes(self)
    }

    fn is_external(&self) -> bool {
        Job::external(self).is_some()
    }

    fn stage(&self, name: &str, state: Vec<u8>, inputs: Vec<Vec<u8>>) -> Result<Stage, JobError> {
        let value = J::State::from_bytes(&state, name)?;
        let is_last = self.is_last(&value);
        Ok(Stage { name: name.to_owned(), state: State::of(state, Arc::new(value)), inputs, is_last })
    }

    fn begin(&self) -> Result<Next, JobError> {
        let external = Job::external(self);
        if let Some(external) = external {
            external.ready().map_err(JobError::Failed)?;
        }
        next(self, unbroken(external, Job::begin(self))?)
    }

    fn block(&self, stage: &Stage, index: usize, parts: &dyn Parts) -> Result<Vec<u8>, JobError> {
        let input = stage.inputs.get(index).ok_or_else(|| unreadable(&stage.name, "there is no such block"))?;
        let input = J::Input::from_bytes(input, &stage.name)?;
        let external = Job::external(self);
        let parts = Unbroken { parts, external };
        unbroken(external, Job::block(self, stage.state.get(&stage.name)?, input, &parts))?.into_bytes()
    }

    fn reduce(&self, stage: &Stage, outputs: Vec<Vec<u8>>) -> Result<Next, JobError> {
        let state: &J::State = stage.state.get(&stage.name)?;
        let reduced = Job::reduce(self, state.clone(), blocks::<J>(stage, outputs)?);
        next(self, unbroken(Job::external(self), reduced)?)
    }

    fn so_far(&self, blocks: Vec<(Vec<u8>, Vec<u8>)>) -> Result<Vec<String>, JobError> {
        let read = |(input, output): (Vec<u8>, Vec<u8>)| -> Result<_, JobError> {
            Ok((J::Input::from_bytes(&input, SO_FAR)?, J::Partial::from_bytes(&output, SO_FAR)?))
        };
        Ok(Job::so_far(self, blocks.into_iter().map(read).collect::<Result<_, _>>()?))
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

/// What was found, unless what answers for the model broke down meanwhile: failures since then say nothing of the model, and
/// must not be kept as if they did.
fn unbroken<T>(external: Option<&External>, found: Result<T, JobError>) -> Result<T, JobError> {
    match external.and_then(External::broken) {
        Some(reason) => Err(JobError::Failed(reason)),
        None => found,
    }
}

/// Keeps no state that was reached after what answers for the model broke down.
struct Unbroken<'a> {
    parts: &'a dyn Parts,
    external: Option<&'a External>,
}

impl Parts for Unbroken<'_> {
    fn find(&self, part: u64) -> Option<Vec<u8>> {
        self.parts.find(part)
    }

    fn is_due(&self) -> bool {
        self.parts.is_due()
    }

    fn keep(&self, part: u64, state: &[u8]) {
        if self.external.and_then(External::broken).is_none() {
            self.parts.keep(part, state);
        }
    }

    fn shared(&self, of: &[u8]) -> Option<Vec<u8>> {
        self.parts.shared(of)
    }

    fn share(&self, of: &[u8], found: &[u8]) {
        if self.external.and_then(External::broken).is_none() {
            self.parts.share(of, found);
        }
    }
}

fn next<J: Job>(job: &J, step: Step<J>) -> Result<Next, JobError> {
    Ok(match step {
        Step::Done(output) => {
            let arrays = J::arrays(&output).into_iter().map(|(_, array)| array).collect();
            Next::Done(ResultDocument { json: stored::result(&*output)?, arrays })
        }
        Step::Blocks { stage: name, state, inputs } => Next::Stage(Stage {
            is_last: job.is_last(&state),
            state: State::new(state, &name)?,
            inputs: inputs.into_iter().map(Block::into_bytes).collect::<Result<_, _>>()?,
            name,
        }),
    })
}
