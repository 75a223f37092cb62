//! Blocks that are not computed by the threads of a run: who takes them over, and how the run learns that they are there.

use std::sync::Arc;

use crate::job::Stage;
use crate::runner::error::RunnerError;
use crate::runner::key::Key;

/// A block that is wanted and not in the cache.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The number under which the run waits for it.
    pub ticket: usize,
    /// Id of its job.
    pub job: String,
    /// Key of its job.
    pub owner: Key,
    /// Its stage.
    pub stage: Arc<Stage>,
    /// Its place in the stage.
    pub index: usize,
    /// The name of its output in the cache.
    pub name: Key,
}

/// What became of a block that was wanted.
#[derive(Debug)]
pub struct Settled {
    /// Its [`Wanted::ticket`].
    pub ticket: usize,
    /// Its output is in the cache; or why there will be none.
    pub result: Result<(), RunnerError>,
}

/// Who computes blocks for a run. What it says is a hint: the run looks into the cache itself, and wants a block again that
/// is not sound there.
pub trait Elsewhere: Sync {
    /// What people call it, as in "jobs to run by ...".
    fn name(&self) -> String;

    /// Takes a block over. Called from the threads of the run, in any order.
    fn want(&self, wanted: Wanted);

    /// Waits a moment, and tells what became of blocks; nothing where it gives all of them up. Called again and again by one
    /// thread. `is_idle`: nothing runs here, so no other block will be wanted before one of these settles.
    ///
    /// # Errors
    /// What concerns all blocks: the whole run ends.
    fn settled(&self, is_idle: bool) -> Result<Option<Vec<Settled>>, RunnerError>;
}
