//! How far a job has come that runs on a cluster.

use super::folder::RunFolder;
use crate::runner::cache::{Cache, Kind, Lookup};
use crate::runner::key::Key;

/// Most blocks that are read for what they say so far.
const MOST_READ: usize = 256;

/// A stage of a job of which some blocks are there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overview {
    /// How many blocks are there.
    pub there: usize,
    /// How many it has.
    pub all: usize,
    /// The run.
    pub run: Key,
    /// Inputs and outputs of the first of those that are there.
    pub blocks: Vec<(Vec<u8>, Vec<u8>)>,
}

/// The stage of a job that the last submission with any block of it has.
pub fn blocks_there(cache: &Cache, job: &Key) -> Option<Overview> {
    for key in RunFolder::all(cache.root()) {
        let run = RunFolder { cache: cache.root().to_owned(), key };
        for submission in run.submissions().into_iter().rev() {
            let Ok(list) = submission.shards() else { continue };
            let Some(record) = list.stages.iter().find(|stage| stage.owner == *job) else { continue };
            let Ok(stage) = submission.stage(record) else { continue };
            let names = (0..record.blocks).filter_map(|index| Some((index, stage.block(&record.owner, index)?)));
            let found: Vec<(usize, Key)> = names.filter(|(_, name)| cache.is_there(name)).collect();
            let read = |(index, name): &(usize, Key)| match cache.get(Kind::Block, name) {
                Lookup::Found(output) => Some((stage.inputs.get(*index)?.clone(), output)),
                Lookup::Absent | Lookup::Damaged => None,
            };
            let blocks = found.iter().take(MOST_READ).filter_map(read).collect();
            return Some(Overview { there: found.len(), all: record.blocks, run: run.key, blocks });
        }
    }
    None
}
