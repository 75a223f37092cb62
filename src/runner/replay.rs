//! A finished job's stages with what their blocks gave, from the cache: what its result leaves out.

use super::cache::{Cache, Kind, Lookup};
use super::engine::block_name;
use super::key::Key;
use crate::job::{JobError, Next, Runnable, Stage};

/// A stage, and the stored output of each of its blocks.
pub type Replayed = (Stage, Vec<Vec<u8>>);

/// The stages of a job of this key. `None` where a block is not in the cache, as after a pruning.
///
/// # Errors
/// What the job gives; bytes that cannot be read.
pub fn replay(job: &dyn Runnable, key: &Key, cache: &Cache) -> Result<Option<Vec<Replayed>>, JobError> {
    let mut stages = Vec::new();
    let mut next = job.begin()?;
    while let Next::Stage(stage) = next {
        let found = |index: usize| match cache.get(Kind::Block, &block_name(key, &stage, index)) {
            Lookup::Found(output) => Some(output),
            Lookup::Absent | Lookup::Damaged => None,
        };
        let Some(outputs) = (0..stage.inputs.len()).map(found).collect::<Option<Vec<_>>>() else { return Ok(None) };
        if stage.is_last {
            stages.push((stage, outputs));
            break;
        }
        next = job.reduce(&stage, outputs.clone())?;
        stages.push((stage, outputs));
    }
    Ok(Some(stages))
}
