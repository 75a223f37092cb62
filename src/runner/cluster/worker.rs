//! A shard on a node: finds which of its blocks are missing, runs these, publishes each, and says how it ended.

use std::path::Path;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::folder::{Failure, Record, ShardList, StageRecord, Submission, WrittenStage};
use crate::document::hash::sha256_hex;
use crate::job::Stage;
use crate::math::sort::sort_by_key;
use crate::runner::cache::{self, Cache, Kind, Lookup};
use crate::runner::engine::block::{Blocks, Halt, Working, caught};
use crate::runner::engine::pool::pool;
use crate::runner::engine::{Settings, block_name};
use crate::runner::error::RunnerError;
use crate::runner::events::Listener;
use crate::runner::plan::Plan;
use crate::runner::polling::stopped_when;
use crate::runner::stored::Stored;

/// A block may go on so long after the scheduler has asked the shard to end.
const LAST_BLOCK: Duration = Duration::from_secs(20);
/// How often a shard looks whether it was asked to end.
const GLANCE: Duration = Duration::from_millis(100);

/// How a shard ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All its blocks are published.
    Published,
    /// Its arguments are wrong.
    Usage,
    /// Its definition is rejected, or a block of it fails and would again.
    Rejected,
    /// It may succeed another time.
    Temporary,
}

impl End {
    /// The exit status.
    pub fn code(self) -> u8 {
        match self {
            Self::Published => 0,
            Self::Usage => 64,
            Self::Rejected => 65,
            Self::Temporary => 75,
        }
    }
}

/// What runs a shard.
pub struct Shard<'a> {
    /// Folder of the submission.
    pub folder: &'a Path,
    /// Its index in the array.
    pub index: usize,
    /// The scheduler's name of this machine, and how often it started the shard again.
    pub task: (Option<String>, u64),
    /// Threads.
    pub settings: Settings,
    /// How often the scheduler asked it to end.
    pub signals: &'a AtomicUsize,
    /// Who hears of blocks.
    pub listener: &'a dyn Listener,
    /// The jobs of a pass.
    pub load: &'a dyn Fn(&Path) -> Result<Plan, String>,
}

/// A stage of which the shard has blocks.
struct Part {
    record: StageRecord,
    written: WrittenStage,
    missing: Vec<usize>,
}

/// Why a shard cannot run.
struct Refusal(End, String);

impl Shard<'_> {
    /// Runs it, writes its record, and gives how it ended, with the reason where it did not publish everything.
    pub fn run(&self) -> (End, Option<String>) {
        let started_s = now_s();
        let (node, restart) = self.task.clone();
        let mut record =
            Record { index: self.index, host: cache::host(), node, restart, started_s, ..Record::default() };
        let submission = match Submission::at(self.folder) {
            Ok(submission) => submission,
            Err(error) => return (End::Usage, Some(error.to_string())),
        };
        let end = match self.publish(&submission, &mut record) {
            Ok(end) => end,
            Err(Refusal(end, reason)) => {
                record.error = Some(reason);
                end
            }
        };
        record.code = end.code();
        record.ended_s = now_s();
        record.program_sha256 = program_sha256();
        if let Err(error) = submission.write_record(&record) {
            // What it published counts; only the reason is lost.
            return (end, Some(record.error.map_or_else(|| error.to_string(), |reason| format!("{reason}; {error}"))));
        }
        (end, record.error)
    }

    fn publish(&self, submission: &Submission, record: &mut Record) -> Result<End, Refusal> {
        let list = submission.shards().map_err(|error| Refusal(End::Temporary, error.to_string()))?;
        let task = format!("{}.{}.{}", submission.number, self.index, record.restart);
        let cache = Cache::new(&submission.run.cache).shared(&task);
        let parts = self.parts(submission, &list, &cache, record)?;
        if parts.is_empty() {
            return Ok(End::Published);
        }
        let mut left = false;
        let mut is_external = false;
        for part in parts {
            let working = self.working(submission, &part.record, &cache)?;
            is_external |= working.job.is_external();
            let WrittenStage { name, state, inputs, .. } = part.written;
            let stage = working.job.stage(&name, state, inputs);
            let stage = stage.map_err(|error| Refusal(End::Rejected, error.to_string()))?;
            left |= self.run_blocks(&working, &stage, &part.missing, &cache, record)?;
        }
        let first = record.failures.first().map(|failure| failure.reason.clone());
        match first {
            // Another machine may have what this one lacks.
            Some(reason) if is_external => {
                record.failures.clear();
                Err(Refusal(End::Temporary, reason))
            }
            Some(reason) => Err(Refusal(End::Rejected, reason)),
            None if left => Err(Refusal(End::Temporary, "it was asked to end before all blocks were run".to_owned())),
            None => Ok(End::Published),
        }
    }

    /// The stages of which blocks are missing.
    fn parts(
        &self,
        submission: &Submission,
        list: &ShardList,
        cache: &Cache,
        record: &mut Record,
    ) -> Result<Vec<Part>, Refusal> {
        let shard = list.shards.get(self.index).ok_or_else(|| {
            Refusal(End::Usage, format!("there is no shard {}: the array has {}", self.index, list.shards.len()))
        })?;
        let mut parts: Vec<Part> = Vec::new();
        for (place, own) in list.stages.iter().enumerate() {
            let ranges = shard.blocks.iter().filter(|range| range.stage == place);
            let wanted: Vec<usize> = ranges.flat_map(|range| range.first..range.first + range.count).collect();
            if wanted.is_empty() {
                continue;
            }
            let written = submission.stage(own).map_err(|error| Refusal(End::Temporary, error.to_string()))?;
            let mut missing = Vec::new();
            for index in wanted {
                let Some(name) = written.block(&own.owner, index) else {
                    return Err(Refusal(End::Rejected, format!("stage `{}` has no block {index}", written.name)));
                };
                // A torn object is moved away and its block run again.
                match cache.get(Kind::Block, &name) {
                    Lookup::Found(_) => record.blocks_found += 1,
                    Lookup::Absent | Lookup::Damaged => missing.push(index),
                }
            }
            if !missing.is_empty() {
                parts.push(Part { record: own.clone(), written, missing });
            }
        }
        Ok(parts)
    }

    /// The job of a stage, made from the study as it was submitted and the results on which it builds.
    fn working(&self, submission: &Submission, stage: &StageRecord, cache: &Cache) -> Result<Working, Refusal> {
        let pass = submission.run.path().join(&stage.pass);
        let plan = (self.load)(&pass).map_err(|reason| Refusal(End::Rejected, reason))?;
        let position = plan.keys().iter().position(|key| *key == stage.owner).ok_or_else(|| {
            let reason = format!(
                "`{}` gives no job of the key {} here: was the program replaced since it was submitted?",
                pass.display(),
                stage.owner.short()
            );
            Refusal(End::Rejected, reason)
        })?;
        let node = &plan.nodes()[position];
        let mut upstream = Vec::new();
        for &other in plan.upstream(position) {
            let key = &plan.keys()[other];
            let Lookup::Found(bytes) = cache.get(Kind::Result, key) else {
                return Err(Refusal(
                    End::Temporary,
                    format!("the result {} on which it builds is not there", key.short()),
                ));
            };
            let stored =
                Stored::from_bytes(&bytes, &node.id).map_err(|error| Refusal(End::Rejected, error.to_string()))?;
            upstream.push(stored.value);
        }
        match caught(|| node.task.prepare(&upstream)) {
            Ok(job) => Ok(Working::new(node.id.clone(), stage.owner.clone(), job)),
            Err(Halt::Failed(error)) => Err(Refusal(End::Rejected, error.to_string())),
            Err(Halt::Stopped) => Err(Refusal(End::Temporary, "it was asked to end".to_owned())),
        }
    }

    /// Runs blocks side by side; whether some were left because the shard was asked to end.
    fn run_blocks(
        &self,
        working: &Working,
        stage: &Stage,
        missing: &[usize],
        cache: &Cache,
        record: &mut Record,
    ) -> Result<bool, Refusal> {
        let blocks = Blocks::new(cache, self.listener, self.settings.keep_every()).storing();
        let (run, left) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let failed: Mutex<Vec<(usize, RunnerError)>> = Mutex::default();
        let is_asked = || self.signals.load(Ordering::SeqCst) > 0;
        let first_asked: Mutex<Option<Instant>> = Mutex::default();
        let is_over = || {
            is_asked()
                && (first_asked.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(Instant::now))
                    .elapsed()
                    >= LAST_BLOCK
        };
        let one = |index: usize| {
            let least = || failed.lock().unwrap_or_else(PoisonError::into_inner).iter().map(|(index, _)| *index).min();
            // What stands behind a block that failed no longer matters.
            if least().is_some_and(|least| least < index) {
                return;
            }
            if is_asked() {
                left.fetch_add(1, Ordering::Relaxed);
                return;
            }
            match blocks.run(working, stage, index) {
                Ok(_) => {
                    run.fetch_add(1, Ordering::Relaxed);
                }
                Err(Halt::Stopped) => {
                    left.fetch_add(1, Ordering::Relaxed);
                }
                Err(Halt::Failed(error)) => failed.lock().unwrap_or_else(PoisonError::into_inner).push((index, error)),
            }
        };
        let done = stopped_when(GLANCE, is_over, |stop| {
            let pool = pool(&self.settings, stop)?;
            pool.in_place_scope_fifo(|scope| {
                for &index in missing {
                    let one = &one;
                    scope.spawn_fifo(move |_| one(index));
                }
            });
            Ok::<(), RunnerError>(())
        });
        done.map_err(|error| Refusal(End::Temporary, error.to_string()))?;
        record.blocks_run += run.into_inner();
        let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        sort_by_key(&mut failed, |(index, _)| *index);
        for (index, error) in failed {
            match error {
                RunnerError::Job { source, .. } => {
                    let block = block_name(&working.key, stage, index);
                    record.failures.push(Failure { block, index, reason: source.to_string() });
                }
                // Other bytes than another machine's: both are kept, and nothing is tried again.
                error @ RunnerError::Nondeterministic { .. } => return Err(Refusal(End::Rejected, error.to_string())),
                error => return Err(Refusal(End::Temporary, error.to_string())),
            }
        }
        Ok(left.into_inner() > 0)
    }
}

fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |elapsed| elapsed.as_secs_f64())
}

/// SHA-256 of this program; empty where it cannot be read.
pub fn program_sha256() -> String {
    std::env::current_exe().and_then(std::fs::read).map_or_else(|_| String::new(), |bytes| sha256_hex(&bytes))
}
