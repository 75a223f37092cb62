//! How blocks are divided into shards: runs of equal length, in the order of jobs, stages and blocks.

use super::scheduler::Limits;

/// Most shards, unless more are asked for.
const MOST: usize = 1000;
/// Shards a slot, so that slots stay busy although shards differ.
const A_SLOT: usize = 4;

/// How many shards so many blocks become.
///
/// # Errors
/// More were asked for than an array may have.
pub fn count(blocks: usize, asked: Option<usize>, cpus_per_task: usize, limits: &Limits) -> Result<usize, String> {
    let most = match (limits.array, limits.jobs) {
        // One job is left for what goes on after the array.
        (array, Some(jobs)) => array.unwrap_or(usize::MAX).min(jobs.saturating_sub(1)),
        (array, None) => array.unwrap_or(usize::MAX),
    };
    if let Some(asked) = asked {
        if asked > most {
            return Err(format!(
                "an array of {asked} shards is too large: this cluster takes at most {most} (MaxArraySize, MaxJobCount); \
                 give --shards {most} or fewer: a shard may have several blocks"
            ));
        }
        return Ok(asked.clamp(1, blocks.max(1)));
    }
    let slots = limits.processors.map_or(MOST, |processors| (processors / cpus_per_task.max(1)).max(1));
    Ok(blocks.min(slots.saturating_mul(A_SLOT)).min(most).clamp(1, MOST))
}

/// The runs: where each begins and ends among all blocks. Lengths differ by one at most.
pub fn runs(blocks: usize, shards: usize) -> Vec<std::ops::Range<usize>> {
    (0..shards)
        .map(|shard| shard * blocks / shards..(shard + 1) * blocks / shards)
        .filter(|run| !run.is_empty())
        .collect()
}
