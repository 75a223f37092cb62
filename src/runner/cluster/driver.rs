//! Follows a run on a cluster: submits the blocks that the engine wants, looks what became of them, submits again what is
//! missing. It may be killed at any time: another one goes on from the cache and the run's folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::folder::{LOG, Range, RunFolder, RunRecord, SCRIPT, ShardList, ShardRecord, StageRecord, Submission};
use super::scheduler::{Limits, Request, Scheduler, SchedulerError};
use super::shards;
use super::tracking::{Array, Block, News, Tracked};
use crate::document::counted;
use crate::job::JobError;
use crate::math::sort::sort_by;
use crate::runner::cache::Cache;
use crate::runner::engine::elsewhere::{Elsewhere, Settled, Wanted};
use crate::runner::error::RunnerError;
use crate::runner::events::{Event, Listener};
use crate::runner::key::Key;

/// How often a block is submitted at most.
const MOST_ATTEMPTS: u32 = 3;
/// A machine is no longer used after so many failures in a row.
const FAILURES_OF_A_NODE: usize = 2;
/// Pause of a look at what happened.
const PAUSE: Duration = Duration::from_millis(100);
/// Blocks wait so long for others, to be submitted with them, while the run still finds out what it wants.
const COLLECTED_FOR: Duration = Duration::from_secs(2);
/// A second Ctrl-C within this time cancels; else the run is left.
const SECOND_CHANCE: Duration = Duration::from_secs(3);
/// An answer of `sbatch` that was lost is looked for so often.
const LOOKS_FOR_LOST: u32 = 5;
/// The job that goes on when an array has ended.
const COLLECT_SCRIPT: &str = "collect.sh";

/// How far a driver goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Until all is done.
    Wait,
    /// Until what can be submitted is.
    Detach,
    /// Only what is there is reduced; nothing is submitted.
    Collect,
}

/// Follows a run.
pub struct Driver<'a> {
    /// Its folder.
    pub folder: &'a RunFolder,
    /// What was asked for.
    pub record: &'a RunRecord,
    /// The scheduler.
    pub scheduler: &'a dyn Scheduler,
    /// The cache.
    pub cache: &'a Cache,
    /// Who is informed.
    pub listener: &'a dyn Listener,
    /// How far it goes.
    pub mode: Mode,
    /// The pass of each job, as it was submitted.
    pub passes: BTreeMap<Key, PathBuf>,
    /// How often Ctrl-C was pressed.
    pub signals: &'a AtomicUsize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    wanted: Vec<Block>,
    since: Option<Instant>,
    arrays: Vec<Array>,
    limits: Option<Limits>,
    excluded: BTreeSet<String>,
    failures: BTreeMap<String, usize>,
    next_submission: u32,
    /// Shards of arrays of earlier drivers that may be under way, by the block: place of the array and of the shard.
    adopted: BTreeMap<Key, (usize, usize)>,
    /// How often blocks were submitted by earlier drivers.
    attempts: BTreeMap<Key, u32>,
    first_signal: Option<Instant>,
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Driver<'a> {
    /// A driver that knows the arrays of earlier ones which the scheduler still has.
    ///
    /// # Errors
    /// Submissions that cannot be read.
    pub fn new(
        folder: &'a RunFolder,
        record: &'a RunRecord,
        scheduler: &'a dyn Scheduler,
        cache: &'a Cache,
        listener: &'a dyn Listener,
        mode: Mode,
        passes: BTreeMap<Key, PathBuf>,
        signals: &'a AtomicUsize,
    ) -> Result<Self, RunnerError> {
        let mut state = State { next_submission: 1, ..State::default() };
        let driver =
            Self { folder, record, scheduler, cache, listener, mode, passes, signals, state: Mutex::default() };
        for submission in folder.submissions() {
            state.next_submission = submission.number + 1;
            driver.adopt(submission, &mut state)?;
        }
        *lock(&driver.state) = state;
        Ok(driver)
    }

    /// Takes over an array that an earlier driver submitted.
    fn adopt(&self, submission: Submission, state: &mut State) -> Result<(), RunnerError> {
        let Ok(list) = submission.shards() else { return Ok(()) };
        let goes_on = self.record.options.finish_on_cluster;
        let job = match submission.job() {
            Some(job) => Some(job),
            // It may have been accepted by a driver that was killed before it could note so.
            None => self.scheduler.find(&self.folder.name(), &self.folder.comment(submission.number)).unwrap_or(None),
        };
        let Some(job) = job else { return Ok(()) };
        let is_alive = match self.scheduler.tasks(&job, &self.folder.name()) {
            Ok(tasks) => !tasks.is_empty(),
            Err(_) => true,
        };
        if !is_alive && !goes_on {
            return Ok(());
        }
        let mut names: Vec<Vec<Key>> = Vec::new();
        for record in &list.stages {
            let stage = submission.stage(record)?;
            names.push((0..record.blocks).filter_map(|index| stage.block(&record.owner, index)).collect());
        }
        let place = state.arrays.len();
        for (index, shard) in list.shards.iter().enumerate() {
            for range in &shard.blocks {
                let blocks = names.get(range.stage).into_iter().flatten().skip(range.first).take(range.count);
                for name in blocks {
                    state.attempts.insert(name.clone(), shard.attempt);
                    if is_alive {
                        state.adopted.insert(name.clone(), (place, index));
                    }
                }
            }
        }
        if is_alive {
            self.tell(format!("array {job} of an earlier run is under way: {}", counted(list.shards.len(), "shard")));
            let shards = list.shards.iter().map(|_| Tracked::default()).collect();
            state.arrays.push(Array::new(submission, job, shards, self.longest()));
        }
        Ok(())
    }

    fn longest(&self) -> Duration {
        Duration::from_secs(self.record.options.poll_s.max(1))
    }

    fn tell(&self, text: String) {
        self.listener.hear(&Event::Cluster { text });
    }

    fn refused(&self, error: SchedulerError) -> RunnerError {
        RunnerError::Scheduler { scheduler: self.scheduler.name(), reason: error.to_string() }
    }

    /// Submits what is wanted and ready, as one array.
    fn submit(&self, state: &mut State) -> Result<(), RunnerError> {
        let now = Instant::now();
        let (mut ready, later): (Vec<Block>, Vec<Block>) =
            std::mem::take(&mut state.wanted).into_iter().partition(|block| block.ready_at <= now);
        (state.wanted, state.since) = (later, None);
        if ready.is_empty() {
            return Ok(());
        }
        // Those that failed before stand by themselves: one bad block must not take others along again.
        sort_by(&mut ready, |a, b| {
            let order = |block: &Block| {
                (block.attempt, block.wanted.job.clone(), block.wanted.stage.name.clone(), block.wanted.index)
            };
            order(a).cmp(&order(b))
        });
        let limits = match state.limits {
            Some(limits) => limits,
            None => {
                let limits = self.scheduler.limits(&self.record.options).map_err(|error| self.refused(error))?;
                if limits.keeps_accounts == Some(false) {
                    self.tell(format!(
                        "this {} keeps no accounts: why a task ended is known for some minutes only",
                        self.scheduler.name()
                    ));
                }
                limits
            }
        };
        state.limits = Some(limits);
        let options = &self.record.options;
        let count = shards::count(ready.len(), options.shards, options.cpus_per_task, &limits)
            .map_err(|reason| RunnerError::Submission { reason })?;
        let submission = Submission { run: self.folder.clone(), number: state.next_submission };
        state.next_submission += 1;
        let (list, shards) = self.write(&submission, ready, count)?;
        let job = self.hand_in(&submission, list.shards.len(), state)?;
        submission.set_submitted(&job)?;
        let blocks: usize = shards.iter().map(|shard| shard.blocks.len()).sum();
        self.tell(format!(
            "array {job}: {} in {}; run {}",
            counted(blocks, "block"),
            counted(list.shards.len(), "shard"),
            self.folder.key.short()
        ));
        state.arrays.push(Array::new(submission, job, shards, self.longest()));
        Ok(())
    }

    /// Writes the files that the tasks of an array read.
    fn write(
        &self,
        submission: &Submission,
        ready: Vec<Block>,
        count: usize,
    ) -> Result<(ShardList, Vec<Tracked>), RunnerError> {
        submission.make_folders()?;
        let mut stages: Vec<StageRecord> = Vec::new();
        let mut places: BTreeMap<(Key, String), usize> = BTreeMap::new();
        let mut shards: Vec<ShardRecord> = Vec::new();
        let mut tracked: Vec<Tracked> = Vec::new();
        let runs = shards::runs(ready.len(), count);
        let mut ready = ready.into_iter();
        for run in runs {
            let blocks: Vec<Block> =
                ready.by_ref().take(run.len()).map(|block| Block { attempt: block.attempt + 1, ..block }).collect();
            let mut ranges: Vec<Range> = Vec::new();
            for Block { wanted, .. } in &blocks {
                let identity = (wanted.owner.clone(), wanted.stage.name.clone());
                let stage = match places.get(&identity) {
                    Some(&place) => place,
                    None => {
                        let pass = self.passes.get(&wanted.owner).map_or_else(|| Path::new(""), PathBuf::as_path);
                        stages.push(submission.write_stage(stages.len(), &wanted.stage, pass, &wanted.owner)?);
                        places.insert(identity, stages.len() - 1);
                        stages.len() - 1
                    }
                };
                match ranges.last_mut() {
                    Some(last) if last.stage == stage && last.first + last.count == wanted.index => last.count += 1,
                    _ => ranges.push(Range { stage, first: wanted.index, count: 1 }),
                }
            }
            let attempt = blocks.iter().map(|block| block.attempt).max().unwrap_or(1);
            shards.push(ShardRecord { attempt, blocks: ranges });
            tracked.push(Tracked::of(blocks));
        }
        let list = ShardList { stages, shards };
        submission.write_shards(&list)?;
        submission.write_script(SCRIPT, &self.script(submission)?)?;
        Ok((list, tracked))
    }

    /// The command of this program on a node, up to its verb.
    fn program(&self) -> Result<String, RunnerError> {
        let program = std::env::current_exe().map_err(RunnerError::file("find", "bmv"))?;
        let settings = self.folder.path().join("settings");
        let mut text = String::from("#!/bin/sh\n");
        if settings.exists() {
            text.push_str(&format!("export XDG_CONFIG_HOME={}\n", quoted(&settings)));
        }
        text.push_str(&format!("exec {} --color never", quoted(&program)));
        for (is_given, flag) in [
            (self.record.allow_commands, "--allow-commands"),
            (self.record.allow_remote_models, "--allow-remote-models"),
        ] {
            if is_given {
                text.push_str(&format!(" {flag}"));
            }
        }
        Ok(text)
    }

    fn script(&self, submission: &Submission) -> Result<String, RunnerError> {
        let variables = self.scheduler.variables();
        Ok(format!(
            "{} shard --run {} --index \"${}\" --threads {} --node \"${}\" --restart \"${{{}:-0}}\"\n",
            self.program()?,
            quoted(&submission.path()),
            variables.index,
            self.record.options.cpus_per_task,
            variables.node,
            variables.restart,
        ))
    }

    /// Gives an array to the scheduler. Where its answer is lost, the array is looked for before anything else is done.
    fn hand_in(&self, submission: &Submission, tasks: usize, state: &State) -> Result<String, RunnerError> {
        let (name, comment) = (self.folder.name(), self.folder.comment(submission.number));
        let folder = submission.path();
        let log = folder.join(LOG);
        if !log.is_dir() {
            // Slurm says nothing of it, and the tasks fail.
            return Err(RunnerError::Submission {
                reason: format!("the folder of logs `{}` is missing", log.display()),
            });
        }
        let exclude: Vec<String> = state.excluded.iter().cloned().collect();
        let request = Request {
            name: &name,
            comment: &comment,
            tasks: Some(tasks),
            folder: &folder,
            log: &log,
            script: &folder.join(SCRIPT),
            exclude: &exclude,
            after: None,
            options: &self.record.options,
        };
        let lost = match self.scheduler.submit(&request) {
            Ok(job) => return Ok(job),
            Err(error @ SchedulerError::Refused(_)) => return Err(self.refused(error)),
            Err(error) => error,
        };
        self.tell(format!(
            "{}: no answer to a submission; looking whether it was accepted: {lost}",
            self.scheduler.name()
        ));
        for look in 1..=LOOKS_FOR_LOST {
            std::thread::sleep(Duration::from_secs(2 * u64::from(look)));
            match self.scheduler.find(&name, &comment) {
                Ok(Some(job)) => return Ok(job),
                Ok(None) => return self.scheduler.submit(&request).map_err(|error| self.refused(error)),
                Err(_) => {}
            }
        }
        Err(self.refused(lost))
    }

    /// Submits the job that goes on when the arrays have ended.
    fn hand_in_collector(&self, array: &Array) -> Result<(), RunnerError> {
        let text = format!("{} collect --finish-on-cluster --run {}\n", self.program()?, quoted(&self.folder.path()));
        let script = array.submission.write_script(COLLECT_SCRIPT, &text)?;
        let folder = array.submission.path();
        let request = Request {
            name: &format!("{}-collect", self.folder.name()),
            comment: &self.folder.comment(array.submission.number),
            tasks: None,
            folder: &folder,
            log: &folder.join(LOG),
            script: &script,
            exclude: &[],
            after: Some(&array.job),
            options: &self.record.options,
        };
        let job = self.scheduler.submit(&request).map_err(|error| self.refused(error))?;
        self.tell(format!("job {job} goes on when array {} has ended", array.job));
        Ok(())
    }

    /// Takes news of an array: what settled, and what is submitted again.
    fn take(&self, state: &mut State, place: usize, news: Vec<News>) -> Result<Vec<Settled>, RunnerError> {
        let mut settled = Vec::new();
        let mut missing: BTreeMap<usize, Vec<Block>> = BTreeMap::new();
        for item in news {
            match item {
                News::There(shard, block) => {
                    let record = state.arrays.get(place).and_then(|array| array.shards.get(shard)?.record.as_ref());
                    if let Some(node) = record.map(|record| record.node.clone().unwrap_or_else(|| record.host.clone()))
                    {
                        state.failures.remove(&node);
                    }
                    settled.push(Settled { ticket: block.wanted.ticket, result: Ok(()) });
                }
                News::Failed(block, reason) => {
                    settled.push(Settled { ticket: block.wanted.ticket, result: Err(failed(&block, reason)) });
                }
                News::Missing(shard, block) => missing.entry(shard).or_default().push(block),
            }
        }
        if missing.is_empty() {
            return Ok(settled);
        }
        let Some(array) = state.arrays.get(place) else { return Ok(settled) };
        let endings = self.scheduler.endings(&array.job);
        let job = array.job.clone();
        let log = array.submission.path().join(LOG);
        let is_cancelled = |shard: &usize| endings.iter().any(|ending| ending.index == *shard && ending.is_cancelled());
        if self.folder.is_cancelled() || missing.keys().any(is_cancelled) {
            return Err(RunnerError::Scheduler {
                scheduler: self.scheduler.name(),
                reason: format!(
                    "array {job} was cancelled; blocks that are there stay, and `bmv run` computes the rest"
                ),
            });
        }
        for (shard, blocks) in missing {
            let record = state.arrays.get(place).and_then(|array| array.shards.get(shard)?.record.clone());
            let ending = endings.iter().find(|ending| ending.index == shard);
            let node = (record.as_ref().map(|record| record.node.clone().unwrap_or_else(|| record.host.clone())))
                .or_else(|| ending.and_then(|ending| ending.node.clone()))
                .unwrap_or_else(|| "an unknown node".to_owned());
            let (code, why) = match (&record, ending) {
                (Some(record), _) if record.code != 0 => {
                    (record.code.to_string(), record.error.clone().unwrap_or_else(|| "it says nothing more".to_owned()))
                }
                (_, Some(ending)) => (ending.code.clone(), format!("{} {}", ending.state, ending.code)),
                (Some(_), None) => ("0".to_owned(), "it says that all is there, and it is not".to_owned()),
                (None, None) => {
                    ("unknown".to_owned(), "it left no record: are cache and program seen by that machine?".to_owned())
                }
            };
            let in_row = state.failures.entry(node.clone()).or_default();
            *in_row += 1;
            if *in_row >= FAILURES_OF_A_NODE && state.excluded.insert(node.clone()) {
                self.tell(format!("{node} failed {in_row} times in a row: it is not used any more"));
            }
            self.tell(format!("array {job}, shard {shard} on {node}: {why}"));
            let is_final = code == "65" || code == "64";
            // A shard whose time was over and that got further may go on as often as it does.
            let got_further = code == "75" && record.as_ref().is_some_and(|record| record.blocks_run > 0);
            for mut block in blocks {
                let twice = block.causes.iter().any(|(other, own)| *own == code && *other != node && code != "75");
                block.causes.push((node.clone(), code.clone()));
                block.attempt -= u32::from(got_further && block.attempt > 0);
                if is_final || twice || block.attempt >= MOST_ATTEMPTS {
                    let attempts = if is_final {
                        String::new()
                    } else {
                        format!(" after {}", counted(u64::from(block.attempt), "attempt"))
                    };
                    let reason = format!(
                        "no result from the cluster{attempts}: {why} ({node}; {})",
                        log.join(format!("{shard}.out")).display()
                    );
                    settled.push(Settled { ticket: block.wanted.ticket, result: Err(failed(&block, reason)) });
                    continue;
                }
                let delay = self.record.options.retry_delay_s << block.attempt.saturating_sub(1).min(16);
                block.ready_at = Instant::now() + Duration::from_secs(delay);
                state.wanted.push(block);
            }
        }
        Ok(settled)
    }

    /// What Ctrl-C asks for: whether the run is left. The first one leaves, a second one within a moment cancels.
    fn heeds(&self, state: &mut State) -> bool {
        let count = self.signals.load(Ordering::SeqCst);
        if count == 0 {
            return false;
        }
        let first = match state.first_signal {
            Some(first) => first,
            None => {
                self.tell(format!(
                    "leaving the run, which goes on; once more within {} s cancels it",
                    SECOND_CHANCE.as_secs()
                ));
                *state.first_signal.insert(Instant::now())
            }
        };
        let key = self.folder.key.short();
        if count >= 2 {
            for array in &state.arrays {
                if let Err(error) = self.scheduler.cancel(&array.job) {
                    self.tell(format!("array {} could not be cancelled: {error}", array.job));
                }
            }
            // Whoever else follows the run must not submit anything again.
            let _ = self.folder.set_cancelled(true);
            self.tell(format!("cancelled; blocks that are there stay, and `bmv run` computes the rest (run {key})"));
            return true;
        }
        if first.elapsed() < SECOND_CHANCE {
            return false;
        }
        self.tell(format!("left; `bmv attach {key}` follows it again, `bmv cancel {key}` ends it"));
        true
    }

    /// Whether this is as far as the driver goes.
    fn is_at_end(&self, state: &State, is_idle: bool) -> Result<bool, RunnerError> {
        if !is_idle {
            return Ok(false);
        }
        let open: usize = state.arrays.iter().map(Array::open_blocks).sum();
        let key = self.folder.key.short();
        match self.mode {
            Mode::Wait => {
                let limit = self.record.options.pending_timeout_s.map(Duration::from_secs);
                let is_stuck = |array: &Array| {
                    !array.is_open()
                        || array.stuck_since.zip(limit).is_some_and(|(since, limit)| since.elapsed() >= limit)
                };
                let is_over = open > 0 && state.wanted.is_empty() && state.arrays.iter().all(is_stuck);
                if is_over {
                    self.tell(format!("nothing moves any more: no longer waiting; `bmv cancel {key}` ends what waits"));
                }
                Ok(is_over)
            }
            Mode::Detach => {
                if !state.wanted.is_empty() {
                    return Ok(false);
                }
                if let (true, Some(array)) = (self.record.options.finish_on_cluster, state.arrays.last()) {
                    self.hand_in_collector(array)?;
                }
                self.tell(format!(
                    "submitted; `bmv attach {key}` follows it, `bmv collect {key}` reduces what is there"
                ));
                Ok(true)
            }
            Mode::Collect => {
                let missing = state.wanted.len() + open;
                let total: usize = {
                    let mut stages: BTreeMap<(&Key, &str), usize> = BTreeMap::new();
                    for block in &state.wanted {
                        stages.insert((&block.wanted.owner, &block.wanted.stage.name), block.wanted.stage.inputs.len());
                    }
                    stages.values().sum()
                };
                self.tell(format!(
                    "{} of {} are there; `bmv run` or `bmv attach {key}` computes the rest",
                    total.saturating_sub(missing),
                    counted(total.max(missing), "block")
                ));
                Ok(true)
            }
        }
    }
}

/// A path in a script of the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}

/// That a block has no result.
fn failed(block: &Block, reason: String) -> RunnerError {
    RunnerError::Job {
        job: block.wanted.job.clone(),
        stage: Some(block.wanted.stage.name.clone()),
        block: Some(block.wanted.index),
        source: JobError::Failed(reason),
    }
}

/// A number from 0 to 1 that differs between programs and moments.
fn jitter() -> f64 {
    let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.subsec_nanos());
    f64::from(nanoseconds.wrapping_add(std::process::id()) % 1000) / 1000.0
}

impl Elsewhere for Driver<'_> {
    fn name(&self) -> String {
        self.scheduler.name().to_owned()
    }

    fn want(&self, wanted: Wanted) {
        let mut state = lock(&self.state);
        let attempt = state.attempts.get(&wanted.name).copied().unwrap_or(0);
        let block = Block { wanted, attempt, ready_at: Instant::now(), causes: Vec::new() };
        let adopted = match self.mode {
            Mode::Collect => None,
            _ => state.adopted.remove(&block.wanted.name),
        };
        if let Some((array, shard)) = adopted
            && let Some(tracked) = state.arrays.get_mut(array).and_then(|array| array.shards.get_mut(shard))
        {
            tracked.blocks.push(block);
            return;
        }
        let fresh = if self.record.options.finish_on_cluster { block.attempt } else { 0 };
        state.wanted.push(Block { attempt: fresh, ..block });
        state.since.get_or_insert_with(Instant::now);
    }

    fn settled(&self, is_idle: bool) -> Result<Option<Vec<Settled>>, RunnerError> {
        let mut state = lock(&self.state);
        if self.heeds(&mut state) {
            return Ok(None);
        }
        let now = Instant::now();
        let is_ready = state.wanted.iter().any(|block| block.ready_at <= now);
        let has_waited = state.since.is_some_and(|since| since.elapsed() >= COLLECTED_FOR);
        if self.mode != Mode::Collect && is_ready && (is_idle || has_waited) {
            self.submit(&mut state)?;
        }
        let mut settled = Vec::new();
        for place in 0..state.arrays.len() {
            if !state.arrays[place].is_open() {
                continue;
            }
            let tell = |text| self.tell(text);
            let news = state.arrays[place].look(self.scheduler, self.cache, jitter(), &tell);
            settled.extend(self.take(&mut state, place, news)?);
        }
        if settled.is_empty() {
            if self.is_at_end(&state, is_idle)? {
                return Ok(None);
            }
            drop(state);
            std::thread::sleep(PAUSE);
        }
        Ok(Some(settled))
    }
}
