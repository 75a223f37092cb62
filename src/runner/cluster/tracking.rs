//! An array that was submitted: what is still waited for, and what its tasks and the cache say of it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use super::folder::{Record, Submission};
use super::scheduler::{Scheduler, Task, Wait};
use crate::runner::cache::Cache;
use crate::runner::engine::elsewhere::Wanted;

/// A block is taken for absent when it is not there so long after its task ended: a shared file system may hide what is new.
const HIDDEN_FOR: Duration = Duration::from_secs(10);
/// First time between two looks at the scheduler.
pub(super) const FIRST_PAUSE: Duration = Duration::from_secs(2);
/// Between two looks at the records of shards.
const GLANCE: Duration = Duration::from_millis(500);
/// Between two attempts to hasten one task.
const HASTEN_AGAIN: Duration = Duration::from_secs(10);

/// A block that is computed elsewhere.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub wanted: Wanted,
    /// How often it was submitted.
    pub attempt: u32,
    /// Not submitted before.
    pub ready_at: Instant,
    /// Where it failed, and with which code.
    pub causes: Vec<(String, String)>,
}

/// A shard that was submitted.
#[derive(Debug, Default)]
pub(super) struct Tracked {
    /// Its blocks that are not there.
    pub blocks: Vec<Block>,
    /// How it ended last, in its own words.
    pub record: Option<Record>,
    /// Whether the scheduler has it.
    task: Option<Task>,
    /// Since when its blocks are missing although it has ended.
    missing_since: Option<Instant>,
    hastened: Option<Instant>,
}

impl Tracked {
    /// A shard of these blocks, of which nothing is known yet.
    pub fn of(blocks: Vec<Block>) -> Self {
        Self { blocks, ..Self::default() }
    }
}

/// What became of blocks of an array.
#[derive(Debug)]
pub(super) enum News {
    /// The object is there.
    There(usize, Block),
    /// It failed, and would again.
    Failed(Block, String),
    /// Its task has ended and there is no object.
    Missing(usize, Block),
}

/// An array that was submitted.
#[derive(Debug)]
pub(super) struct Array {
    pub submission: Submission,
    pub job: String,
    pub shards: Vec<Tracked>,
    /// Since when all that is left waits for what does not come by itself.
    pub stuck_since: Option<Instant>,
    records_seen: BTreeSet<String>,
    looked: Option<Instant>,
    glanced: Option<Instant>,
    pause: Duration,
    longest: Duration,
    reported: BTreeSet<String>,
}

impl Array {
    pub fn new(submission: Submission, job: String, shards: Vec<Tracked>, longest: Duration) -> Self {
        Self {
            submission,
            job,
            shards,
            stuck_since: None,
            records_seen: BTreeSet::new(),
            looked: None,
            glanced: None,
            pause: FIRST_PAUSE.min(longest),
            longest,
            reported: BTreeSet::new(),
        }
    }

    /// Whether blocks of it are still waited for.
    pub fn is_open(&self) -> bool {
        self.shards.iter().any(|shard| !shard.blocks.is_empty())
    }

    /// Number of blocks that are waited for.
    pub fn open_blocks(&self) -> usize {
        self.shards.iter().map(|shard| shard.blocks.len()).sum()
    }

    /// Looks whether blocks are there: at the records of shards often, at the scheduler less often. `jitter` below 1 spreads
    /// the looks of several programs.
    pub fn look(&mut self, scheduler: &dyn Scheduler, cache: &Cache, jitter: f64, tell: &dyn Fn(String)) -> Vec<News> {
        let now = Instant::now();
        let is_due = |last: Option<Instant>, pause: Duration| last.is_none_or(|last| now.duration_since(last) >= pause);
        if !is_due(self.glanced, GLANCE) {
            return Vec::new();
        }
        self.glanced = Some(now);
        let mut changed = self.read_records();
        let asks = is_due(self.looked, self.pause.mul_f64(1.0 + 0.2 * jitter));
        let is_known = asks && self.ask(scheduler, tell);
        if asks {
            self.looked = Some(Instant::now());
            // Every shard now and then: a listing may be old.
            changed.extend(0..self.shards.len());
        }
        let mut news = Vec::new();
        for index in changed {
            let Some(shard) = self.shards.get_mut(index) else { continue };
            shard.look(index, cache, is_known, &mut news);
        }
        if asks {
            let quicker = !news.is_empty();
            self.pause =
                if quicker { FIRST_PAUSE.min(self.longest) } else { self.pause.mul_f64(1.5).min(self.longest) };
        }
        news
    }

    /// Reads records that are new; the shards that they speak of.
    fn read_records(&mut self) -> BTreeSet<usize> {
        let mut changed = BTreeSet::new();
        for name in self.submission.record_names() {
            if self.records_seen.contains(&name) {
                continue;
            }
            let Some(record) = self.submission.record(&name) else { continue };
            self.records_seen.insert(name);
            if let Some(shard) = self.shards.get_mut(record.index) {
                changed.insert(record.index);
                if shard.record.as_ref().is_none_or(|last| last.restart <= record.restart) {
                    shard.record = Some(record);
                }
            }
        }
        changed
    }

    /// Asks the scheduler for the tasks that have not ended; whether it answered.
    fn ask(&mut self, scheduler: &dyn Scheduler, tell: &dyn Fn(String)) -> bool {
        let tasks = match scheduler.tasks(&self.job, &self.submission.run.name()) {
            Ok(tasks) => tasks,
            Err(error) => {
                if self.reported.insert("away".to_owned()) {
                    tell(format!("{} does not answer, which changes nothing: {error}", scheduler.name()));
                }
                return false;
            }
        };
        if self.reported.remove("away") {
            tell(format!("{} answers again", scheduler.name()));
        }
        let mut by_index: BTreeMap<usize, Task> = tasks.into_iter().map(|task| (task.index, task)).collect();
        for (index, shard) in self.shards.iter_mut().enumerate() {
            shard.task = by_index.remove(&index);
        }
        let open = || self.shards.iter().filter(|shard| !shard.blocks.is_empty());
        let reason = |shard: &Tracked| shard.task.as_ref().and_then(|task| task.waits.clone());
        let lasting: Vec<String> =
            open().filter_map(reason).filter(|reason| scheduler.wait(reason) == Wait::Lasting).collect();
        for reason in &lasting {
            if self.reported.insert(reason.clone()) {
                tell(format!("array {}: tasks wait for what may not pass by itself: {reason}", self.job));
            }
        }
        let is_stuck = !lasting.is_empty() && lasting.len() == open().count();
        self.stuck_since = if is_stuck { self.stuck_since.or_else(|| Some(Instant::now())) } else { None };
        for (index, shard) in self.shards.iter_mut().enumerate() {
            let is_delayed = shard
                .task
                .as_ref()
                .and_then(|task| task.waits.as_deref())
                .is_some_and(|reason| scheduler.wait(reason) == Wait::Delay);
            let is_due = shard.hastened.is_none_or(|last| last.elapsed() >= HASTEN_AGAIN);
            if is_delayed && is_due && !shard.blocks.is_empty() {
                if shard.hastened.is_none() {
                    tell(format!("array {}: shard {index} lost its machine; it starts again", self.job));
                }
                shard.hastened = Some(Instant::now());
                scheduler.hasten(&self.job, index);
            }
        }
        true
    }
}

impl Tracked {
    fn look(&mut self, index: usize, cache: &Cache, is_known: bool, news: &mut Vec<News>) {
        let (there, missing): (Vec<Block>, Vec<Block>) =
            std::mem::take(&mut self.blocks).into_iter().partition(|block| cache.is_there(&block.wanted.name));
        self.blocks = missing;
        news.extend(there.into_iter().map(|block| News::There(index, block)));
        self.take_failures(news);
        if self.blocks.is_empty() || self.task.is_some() || !is_known {
            if self.task.is_some() {
                self.missing_since = None;
            }
            return;
        }
        let since = *self.missing_since.get_or_insert_with(Instant::now);
        if since.elapsed() >= HIDDEN_FOR {
            news.extend(std::mem::take(&mut self.blocks).into_iter().map(|block| News::Missing(index, block)));
        }
    }

    /// Blocks that failed, and those of the same stage behind them, which no longer matter.
    fn take_failures(&mut self, news: &mut Vec<News>) {
        let Some(record) = &self.record else { return };
        for failure in &record.failures {
            let of_block = |block: &Block| block.wanted.index == failure.index && failure.block == block.wanted.name;
            let Some(place) = self.blocks.iter().position(of_block) else { continue };
            let failed = self.blocks.remove(place);
            let behind =
                |block: &Block| block.wanted.owner == failed.wanted.owner && block.wanted.index > failed.wanted.index;
            let (moot, left): (Vec<Block>, Vec<Block>) = std::mem::take(&mut self.blocks).into_iter().partition(behind);
            self.blocks = left;
            news.extend(moot.into_iter().map(|block| News::Failed(block, failure.reason.clone())));
            news.push(News::Failed(failed, failure.reason.clone()));
        }
    }
}
