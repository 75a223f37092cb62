//! How long a stage still takes, from what was seen of its blocks: a pure function, so that it can be held against
//! recorded runs.
//!
//! Short blocks end first, so a rate of the first ends says too little. A block that tells its share is carried on in
//! proportion; one that does not, and one that has not begun, is taken for as long as those known, once twice as many have
//! ended as run side by side. Before that the longest of those that tell is a bound, and without one nothing is said.

use super::progress::duration_text;

/// A block's share of its work from which its time is carried on.
const LEAST_SHARE: f64 = 0.05;
/// A forecast from fewer blocks that ended, for each that runs at once, is none.
const ENDS_PER_THREAD: usize = 2;

/// A block that runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningBlock {
    /// Since it began, s.
    pub elapsed_s: f64,
    /// What it tells of its work, 0 to 1; 0 where it tells nothing.
    pub share: f64,
}

/// What is seen of a stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Blocks that were run to their end: how long each took, s.
    pub ended_s: Vec<f64>,
    /// Blocks that run.
    pub running: Vec<RunningBlock>,
    /// Blocks that have not begun.
    pub waiting: usize,
    /// Blocks that can run side by side.
    pub threads: usize,
    /// Whether the job ends with this stage.
    pub is_last: bool,
}

/// The time left of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Left {
    /// Nothing can be said yet.
    Unknown,
    /// So long, s, and longer: stages follow, or blocks of which nothing is known.
    AtLeast(f64),
    /// s.
    About(f64),
}

/// A time left below which nothing is said, s: that it ends at once is what nobody knows of a block that goes on.
const LEAST_S: f64 = 0.5;

impl Left {
    /// `about 3 min left`; nothing where nothing is known, or a part of a second.
    pub fn text(self) -> Option<String> {
        match self {
            Self::Unknown => None,
            Self::AtLeast(left_s) | Self::About(left_s) if left_s < LEAST_S => None,
            Self::AtLeast(left_s) => Some(format!("at least {} left", duration_text(left_s))),
            Self::About(left_s) => Some(format!("about {} left", duration_text(left_s))),
        }
    }
}

/// The time left.
pub fn left(seen: &Seen) -> Left {
    let threads = seen.threads.max(1);
    // How long each block that runs still takes, where that follows from itself.
    let carried = |block: &RunningBlock| {
        (block.share >= LEAST_SHARE).then(|| block.elapsed_s * (1.0 - block.share.min(1.0)) / block.share.min(1.0))
    };
    let projected = seen.running.iter().filter_map(|block| Some(block.elapsed_s + carried(block)?));
    let block_times_s: Vec<f64> = seen.ended_s.iter().copied().chain(projected).collect();
    if seen.running.is_empty() && seen.waiting == 0 {
        return Left::Unknown;
    }
    let is_projected = seen.running.iter().all(|block| carried(block).is_some());
    let at_once = threads.min(seen.ended_s.len() + seen.running.len() + seen.waiting);
    if (seen.waiting > 0 || !is_projected) && seen.ended_s.len() < ENDS_PER_THREAD * at_once {
        // Too few have ended to speak for those that do not speak for themselves.
        let running_s = seen.running.iter().filter_map(carried).fold(0.0, f64::max);
        return if running_s > 0.0 { Left::AtLeast(running_s) } else { Left::Unknown };
    }
    let mean_s = block_times_s.iter().sum::<f64>() / block_times_s.len().max(1) as f64;
    // When each thread is free; what waits goes to the one that is free first.
    let mut free_s: Vec<f64> = seen
        .running
        .iter()
        .map(|block| carried(block).unwrap_or_else(|| (mean_s - block.elapsed_s).max(0.0)))
        .chain(std::iter::repeat(0.0))
        .take(threads.max(seen.running.len()))
        .collect();
    let rounds = seen.waiting / threads;
    if rounds > 1 {
        free_s.iter_mut().for_each(|free| *free += (rounds - 1) as f64 * mean_s);
    }
    for _ in 0..seen.waiting - rounds.saturating_sub(1) * threads {
        if let Some(first) = free_s.iter_mut().min_by(|a, b| a.total_cmp(b)) {
            *first += mean_s;
        }
    }
    let left_s = free_s.into_iter().fold(0.0, f64::max);
    if seen.is_last { Left::About(left_s) } else { Left::AtLeast(left_s) }
}
