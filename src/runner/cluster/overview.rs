//! How far a job has come that runs on a cluster.

use super::folder::RunFolder;
use crate::runner::cache::Cache;
use crate::runner::key::Key;

/// How many blocks of a job's stage are there, and how many it has, by the last submission that has any; with the run.
pub fn blocks_there(cache: &Cache, job: &Key) -> Option<(usize, usize, Key)> {
    for key in RunFolder::all(cache.root()) {
        let run = RunFolder { cache: cache.root().to_owned(), key };
        for submission in run.submissions().into_iter().rev() {
            let Ok(list) = submission.shards() else { continue };
            let Some(record) = list.stages.iter().find(|stage| stage.owner == *job) else { continue };
            let Ok(stage) = submission.stage(record) else { continue };
            let names = (0..record.blocks).filter_map(|index| stage.block(&record.owner, index));
            let there = names.filter(|name| cache.is_there(name)).count();
            return Some((there, record.blocks, run.key));
        }
    }
    None
}
