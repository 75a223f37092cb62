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
pub(super) fn count(
    blocks: usize,
    asked: Option<usize>,
    cpus_per_task: usize,
    limits: &Limits,
) -> Result<usize, String> {
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
pub(super) fn runs(blocks: usize, shards: usize) -> Vec<std::ops::Range<usize>> {
    (0..shards)
        .map(|shard| shard * blocks / shards..(shard + 1) * blocks / shards)
        .filter(|run| !run.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_every_block_once_and_are_of_equal_length() {
        for (blocks, shards) in [(1, 1), (7, 7), (40, 7), (1000, 999), (3, 40)] {
            let runs = runs(blocks, shards);
            let all: Vec<usize> = runs.iter().cloned().flatten().collect();
            assert_eq!(all, (0..blocks).collect::<Vec<_>>());
            let lengths: Vec<usize> = runs.iter().map(ExactSizeIterator::len).collect();
            assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1, "{lengths:?}");
        }
    }

    #[test]
    fn their_number_follows_slots_and_limits() {
        let limits = Limits { array: Some(1001), jobs: Some(10_000), processors: Some(6) };
        assert_eq!(count(500, None, 1, &limits), Ok(24));
        assert_eq!(count(500, None, 2, &limits), Ok(12));
        assert_eq!(count(5, None, 1, &limits), Ok(5));
        assert_eq!(count(500, Some(40), 1, &limits), Ok(40));
        assert_eq!(count(500_000, None, 1, &Limits { processors: Some(100_000), ..limits }), Ok(1000));
        assert_eq!(count(500_000, None, 1, &Limits { array: Some(200), ..limits }).unwrap(), 24);
        let refused = count(5000, Some(1002), 1, &limits).unwrap_err();
        assert!(refused.contains("at most 1001"), "{refused}");
        assert_eq!(count(5000, Some(1001), 1, &limits), Ok(1001));
    }
}
