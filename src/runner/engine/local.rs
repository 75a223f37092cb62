//! The engine of this machine: a pool of threads of its own.
//!
//! Nothing waits inside the pool: each block is a task, the last block of a stage reduces it and starts the next, the last
//! job that another builds upon starts that one. So jobs and blocks of all jobs fill the threads together. Every finished
//! block is published at once, and so are the states that long ones leave on their way; a run that was killed begins where it stopped. A block that is left because the run was
//! asked to stop is one that was not begun. What the system does not let store (another user's cache, a full disk) is
//! used all the same, and the run says so once.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use rayon::ScopeFifo;

use super::pool::pool;
use super::{Finished, Outcome, RunSummary, Settings, StopFlag, block_name};
use crate::job::{JobError, Next, Parts, Runnable, Stage};
use crate::runner::cache::{Cache, Kind, Lookup};
use crate::runner::error::RunnerError;
use crate::runner::events::{Event, Listener};
use crate::runner::key::{Key, block_key, canonical_bytes};
use crate::runner::plan::{Plan, State, Stored};
use crate::watch::{self, Share, Stopped};

/// Runs what is missing of a plan.
///
/// A job that fails does not stop those that do not build upon it; see [`RunSummary`].
///
/// # Errors
/// [`RunnerError::Threads`] if the pool cannot be started. What goes wrong with a job is in its outcome.
pub fn run(
    plan: &Plan,
    cache: &Cache,
    settings: &Settings,
    stop: &StopFlag,
    listener: &dyn Listener,
) -> Result<RunSummary, RunnerError> {
    let threads = settings.threads();
    let pool = pool(settings, stop)?;

    let (states, damaged) = plan.survey(cache, settings.only.as_ref(), settings.force);
    for object in damaged {
        listener.hear(&Event::Damaged { object });
    }
    let count = |wanted: fn(&State) -> bool| states.iter().filter(|state| wanted(state)).count();
    let to_run = count(|state| *state == State::Missing);
    listener.hear(&Event::RunStarted { to_run, cached: count(|state| matches!(state, State::Cached(_))), threads });

    let run = Run::new(plan, cache, settings, stop, listener, &states);
    for (position, state) in states.into_iter().enumerate() {
        if let State::Cached(stored) = state {
            let (job, key) = (plan.nodes()[position].id.clone(), plan.keys()[position].clone());
            listener.hear(&Event::JobCached { job, key: key.clone() });
            let finished = Finished { key, stored, cached: true, blocks_run: 0, blocks_cached: 0 };
            run.slots[position].set(Outcome::Finished(finished));
        }
    }
    pool.scope_fifo(|scope| {
        for position in run.ready_at_once() {
            let run = &run;
            scope.spawn_fifo(move |scope| run.start(scope, position));
        }
    });
    let summary = run.summary();
    listener.hear(&Event::RunFinished {
        finished: summary.outcomes.values().filter(|outcome| outcome.finished().is_some()).count(),
        failed: summary.failures(),
        interrupted: summary.is_interrupted(),
    });
    Ok(summary)
}

/// A job's place in a run.
#[derive(Default)]
struct Slot {
    is_to_run: bool,
    /// Jobs that must end before this one starts.
    waits_for: Vec<usize>,
    waiting: AtomicUsize,
    /// Jobs that wait for this one.
    waited_for_by: Vec<usize>,
    /// An earlier job of the plan with the same key.
    twin: Option<usize>,
    outcome: OnceLock<Outcome>,
}

impl Slot {
    fn set(&self, outcome: Outcome) {
        // Set once by construction: a job is started once and ends once.
        let _ = self.outcome.set(outcome);
    }
}

struct Run<'a> {
    plan: &'a Plan,
    cache: &'a Cache,
    settings: &'a Settings,
    stop: &'a StopFlag,
    listener: &'a dyn Listener,
    slots: Vec<Slot>,
    /// Whether it was reported that something could not be stored.
    told_not_stored: AtomicBool,
}

/// A job that runs.
struct Active {
    position: usize,
    job: Arc<dyn Runnable>,
    work_ns: AtomicU64,
    blocks_run: AtomicUsize,
    blocks_cached: AtomicUsize,
}

/// A stage that runs.
struct Running {
    stage: Stage,
    outputs: Mutex<Vec<Option<Vec<u8>>>>,
    remaining: AtomicUsize,
    /// The failure of the block with the lowest index: the same one for any number of threads.
    failure: Mutex<Option<(usize, RunnerError)>>,
}

impl<'a> Run<'a> {
    fn new(
        plan: &'a Plan,
        cache: &'a Cache,
        settings: &'a Settings,
        stop: &'a StopFlag,
        listener: &'a dyn Listener,
        states: &[State],
    ) -> Self {
        let mut slots: Vec<Slot> = states.iter().map(|_| Slot::default()).collect();
        for position in 0..states.len() {
            if states[position] != State::Missing {
                continue;
            }
            // Equal keys are one computation: the later job waits for the earlier and takes its result.
            let key = &plan.keys()[position];
            let twin = (0..position).find(|&other| plan.keys()[other] == *key && states[other] != State::NotNeeded);
            let mut waits_for: Vec<usize> = plan.upstream(position).iter().copied().chain(twin).collect();
            waits_for.retain(|&other| states[other] == State::Missing);
            waits_for.sort_unstable();
            waits_for.dedup();
            for &other in &waits_for {
                slots[other].waited_for_by.push(position);
            }
            let slot = &mut slots[position];
            (slot.is_to_run, slot.twin) = (true, twin);
            slot.waiting = AtomicUsize::new(waits_for.len());
            slot.waits_for = waits_for;
        }
        Self { plan, cache, settings, stop, listener, slots, told_not_stored: AtomicBool::new(false) }
    }

    fn ready_at_once(&self) -> Vec<usize> {
        (0..self.slots.len()).filter(|&p| self.slots[p].is_to_run && self.slots[p].waits_for.is_empty()).collect()
    }

    fn summary(self) -> RunSummary {
        let nodes = self.plan.nodes().iter();
        let outcomes = nodes.zip(self.slots).filter_map(|(node, slot)| match slot.outcome.into_inner() {
            Some(outcome) => Some((node.id.clone(), outcome)),
            None => slot.is_to_run.then(|| (node.id.clone(), Outcome::Interrupted)),
        });
        RunSummary { outcomes: outcomes.collect() }
    }

    fn id(&self, position: usize) -> String {
        self.plan.nodes()[position].id.clone()
    }

    /// Starts a job whose upstream has ended.
    fn start<'s>(&'s self, scope: &ScopeFifo<'s>, position: usize) {
        match self.prepare(position) {
            Ok(active) => {
                let next = self.guarded(&active, None, None, |job| job.begin());
                self.advance(scope, active, next);
            }
            Err(outcome) => self.end(scope, position, outcome),
        }
    }

    fn prepare(&self, position: usize) -> Result<Arc<Active>, Outcome> {
        for &other in &self.slots[position].waits_for {
            match self.slots[other].outcome.get() {
                Some(Outcome::Finished(_)) => {}
                Some(Outcome::Interrupted) | None => return Err(Outcome::Interrupted),
                Some(Outcome::Failed(_) | Outcome::Skipped { .. }) => {
                    return Err(Outcome::Skipped { upstream: self.id(other) });
                }
            }
        }
        if self.stop.is_stopped() {
            return Err(Outcome::Interrupted);
        }
        let finished = |other: usize| self.slots[other].outcome.get().and_then(Outcome::finished);
        if let Some(twin) = self.slots[position].twin.and_then(finished) {
            return Err(Outcome::Finished(Finished { cached: true, blocks_run: 0, blocks_cached: 0, ..twin.clone() }));
        }
        let upstream = self.plan.upstream(position).iter();
        let upstream: Vec<_> = upstream.filter_map(|&p| finished(p)).map(|f| Arc::clone(&f.stored.value)).collect();
        let node = &self.plan.nodes()[position];
        let key = self.plan.keys()[position].clone();
        self.listener.hear(&Event::JobStarted { job: node.id.clone(), kind: node.task.kind().to_owned(), key });
        let job = caught(|| node.task.prepare(&upstream))
            .map_err(|halt| Outcome::from(halt.at(|source| self.failure(position, None, None, source))))?;
        Ok(Arc::new(Active {
            position,
            job,
            work_ns: AtomicU64::new(0),
            blocks_run: AtomicUsize::new(0),
            blocks_cached: AtomicUsize::new(0),
        }))
    }

    /// Goes on from a step: to the next stage's blocks, or to the end.
    fn advance<'s>(&'s self, scope: &ScopeFifo<'s>, active: Arc<Active>, next: Result<Next, Halt<RunnerError>>) {
        let mut next = next;
        loop {
            match next {
                Err(halt) => return self.end(scope, active.position, halt.into()),
                Ok(Next::Done(value)) => {
                    let outcome = self.publish(&active, &value);
                    let outcome = outcome.map_or_else(|error| Outcome::Failed(Arc::new(error)), Outcome::Finished);
                    return self.end(scope, active.position, outcome);
                }
                Ok(Next::Stage(stage)) => {
                    let (job, blocks, is_last) = (self.id(active.position), stage.inputs.len(), stage.is_last);
                    self.listener.hear(&Event::StageStarted { job, stage: stage.name.clone(), blocks, is_last });
                    if blocks == 0 {
                        next = self.guarded(&active, Some(&stage.name), None, |job| job.reduce(&stage, Vec::new()));
                        continue;
                    }
                    let running = Arc::new(Running {
                        stage,
                        outputs: Mutex::new(vec![None; blocks]),
                        remaining: AtomicUsize::new(blocks),
                        failure: Mutex::new(None),
                    });
                    for index in 0..blocks {
                        let (active, running) = (Arc::clone(&active), Arc::clone(&running));
                        scope.spawn_fifo(move |scope| self.block(scope, active, &running, index));
                    }
                    return;
                }
            }
        }
    }

    /// Takes a block from the cache or runs it; the last one of the stage goes on.
    fn block<'s>(&'s self, scope: &ScopeFifo<'s>, active: Arc<Active>, running: &Running, index: usize) {
        let is_moot = lock(&running.failure).as_ref().is_some_and(|(failed, _)| *failed < index);
        if !is_moot && !self.stop.is_stopped() {
            match self.output(&active, &running.stage, index) {
                Ok(output) => lock(&running.outputs)[index] = Some(output),
                Err(Halt::Stopped) => {}
                Err(Halt::Failed(error)) => {
                    let mut failure = lock(&running.failure);
                    if failure.as_ref().is_none_or(|(failed, _)| index < *failed) {
                        *failure = Some((index, error));
                    }
                }
            }
        }
        // The last one must see what all the others wrote.
        if running.remaining.fetch_sub(1, Ordering::AcqRel) > 1 {
            return;
        }
        if let Some((_, error)) = lock(&running.failure).take() {
            return self.end(scope, active.position, Outcome::Failed(Arc::new(error)));
        }
        let outputs = std::mem::take(&mut *lock(&running.outputs));
        // A block without output was not begun, or was left: the run was interrupted.
        let Some(outputs) = outputs.into_iter().collect::<Option<Vec<_>>>() else {
            return self.end(scope, active.position, Outcome::Interrupted);
        };
        let stage = &running.stage;
        let next = self.guarded(&active, Some(&stage.name), None, |job| job.reduce(stage, outputs));
        self.advance(scope, active, next);
    }

    fn output(&self, active: &Active, stage: &Stage, index: usize) -> Result<Vec<u8>, Halt<RunnerError>> {
        let owner = &self.plan.keys()[active.position];
        let name = block_name(owner, stage, index);
        let cached_block = if self.settings.force { Lookup::Absent } else { self.cache.get(Kind::Block, &name) };
        let (output, cached) = match cached_block {
            Lookup::Found(output) => {
                active.blocks_cached.fetch_add(1, Ordering::Relaxed);
                (output, true)
            }
            Lookup::Absent | Lookup::Damaged => {
                if cached_block == Lookup::Damaged {
                    self.listener.hear(&Event::Damaged { object: name.clone() });
                }
                let share = Share::default();
                self.listener.block_runs(&self.id(active.position), index, &share);
                let (last, refused) = (Cell::new(Instant::now()), RefCell::default());
                let parts = KeptParts { run: self, owner, stage, index, last, refused };
                let run = |job: &dyn Runnable| watch::with_share(&share, || job.block(stage, index, &parts));
                let output = self.guarded(active, Some(&stage.name), Some(index), run)?;
                if let Some(error) = parts.refused.take() {
                    return Err(Halt::Failed(error));
                }
                self.store(Kind::Block, owner, &name, &output).map_err(Halt::Failed)?;
                active.blocks_run.fetch_add(1, Ordering::Relaxed);
                (output, false)
            }
        };
        let (job, stage) = (self.id(active.position), stage.name.clone());
        self.listener.hear(&Event::BlockDone { job, stage, index, cached });
        Ok(output)
    }

    /// Stores an object where the system lets it; only other bytes for the same key are an error.
    fn store(&self, kind: Kind, owner: &Key, name: &Key, payload: &[u8]) -> Result<(), RunnerError> {
        match self.cache.put(kind, owner, name, payload) {
            Err(error @ RunnerError::File { .. }) => {
                if !self.told_not_stored.swap(true, Ordering::Relaxed) {
                    self.listener.hear(&Event::NotStored { reason: error.to_string() });
                }
                Ok(())
            }
            stored => stored,
        }
    }

    fn publish(&self, active: &Active, value: &serde_json::Value) -> Result<Finished, RunnerError> {
        let (job, key) = (self.id(active.position), self.plan.keys()[active.position].clone());
        let bytes = canonical_bytes(value, &format!("the result of job `{job}`"))?;
        self.store(Kind::Result, &key, &key, &bytes)?;
        let finished = Finished {
            key,
            stored: Stored::from_bytes(&bytes, &job)?,
            cached: false,
            blocks_run: active.blocks_run.load(Ordering::Relaxed),
            blocks_cached: active.blocks_cached.load(Ordering::Relaxed),
        };
        self.listener.hear(&Event::JobFinished {
            job,
            kind: active.job.kind().to_owned(),
            key: finished.key.clone(),
            blocks_run: finished.blocks_run,
            blocks_cached: finished.blocks_cached,
            work_s: active.work_ns.load(Ordering::Relaxed) as f64 * 1e-9,
        });
        Ok(finished)
    }

    /// Notes a job's end and starts those that waited for it alone.
    fn end<'s>(&'s self, scope: &ScopeFifo<'s>, position: usize, outcome: Outcome) {
        let job = self.id(position);
        match &outcome {
            Outcome::Failed(error) => self.listener.hear(&Event::JobFailed { job, reason: error.to_string() }),
            Outcome::Skipped { upstream } => {
                self.listener.hear(&Event::JobSkipped { job, upstream: upstream.clone() });
            }
            Outcome::Finished(finished) if finished.cached => {
                self.listener.hear(&Event::JobCached { job, key: finished.key.clone() });
            }
            Outcome::Finished(_) | Outcome::Interrupted => {}
        }
        self.slots[position].set(outcome);
        for &next in &self.slots[position].waited_for_by {
            if self.slots[next].waiting.fetch_sub(1, Ordering::AcqRel) == 1 {
                scope.spawn_fifo(move |scope| self.start(scope, next));
            }
        }
    }

    /// Calls the job's code, measures it, and turns a panic or an error into one that names the place.
    fn guarded<T>(
        &self,
        active: &Active,
        stage: Option<&str>,
        block: Option<usize>,
        call: impl FnOnce(&dyn Runnable) -> Result<T, JobError>,
    ) -> Result<T, Halt<RunnerError>> {
        let begin = Instant::now();
        let result = caught(|| call(active.job.as_ref()));
        let elapsed_ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
        active.work_ns.fetch_add(elapsed_ns, Ordering::Relaxed);
        result.map_err(|halt| halt.at(|source| self.failure(active.position, stage, block, source)))
    }

    fn failure(&self, position: usize, stage: Option<&str>, block: Option<usize>, source: JobError) -> RunnerError {
        RunnerError::Job { job: self.id(position), stage: stage.map(str::to_owned), block, source }
    }
}

/// The states of a block that runs, as objects of the cache.
struct KeptParts<'r, 'a> {
    run: &'r Run<'a>,
    owner: &'r Key,
    stage: &'r Stage,
    index: usize,
    /// When it began, or kept a state.
    last: Cell<Instant>,
    /// Other bytes than an earlier run's.
    refused: RefCell<Option<RunnerError>>,
}

impl KeptParts<'_, '_> {
    fn name(&self, part: u64) -> Key {
        let Stage { name, state, inputs, .. } = self.stage;
        let determining = [state.bytes(), &inputs[self.index]];
        block_key(self.owner, &format!("{name}, part {part}"), self.index, &determining)
    }
}

impl Parts for KeptParts<'_, '_> {
    fn find(&self, part: u64) -> Option<Vec<u8>> {
        if self.run.settings.force {
            return None;
        }
        let name = self.name(part);
        match self.run.cache.get(Kind::Block, &name) {
            Lookup::Found(state) => Some(state),
            Lookup::Absent => None,
            Lookup::Damaged => {
                self.run.listener.hear(&Event::Damaged { object: name });
                None
            }
        }
    }

    fn is_due(&self) -> bool {
        self.last.get().elapsed() >= self.run.settings.keep_every()
    }

    fn keep(&self, part: u64, state: &[u8]) {
        self.last.set(Instant::now());
        if let Err(error) = self.run.store(Kind::Block, self.owner, &self.name(part), state) {
            self.refused.replace(Some(error));
        }
    }
}

/// Why a job's code gave nothing.
enum Halt<E> {
    /// The run was asked to stop.
    Stopped,
    Failed(E),
}

impl<E> Halt<E> {
    /// The same with the place of a failure.
    fn at<F>(self, place: impl FnOnce(E) -> F) -> Halt<F> {
        match self {
            Self::Stopped => Halt::Stopped,
            Self::Failed(error) => Halt::Failed(place(error)),
        }
    }
}

impl From<Halt<RunnerError>> for Outcome {
    fn from(halt: Halt<RunnerError>) -> Self {
        match halt {
            Halt::Stopped => Self::Interrupted,
            Halt::Failed(error) => Self::Failed(Arc::new(error)),
        }
    }
}

/// Calls, and turns a panic into an error. The job is not used again after one, so it may be in any state.
fn caught<T>(call: impl FnOnce() -> Result<T, JobError>) -> Result<T, Halt<JobError>> {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result.map_err(Halt::Failed),
        Err(payload) if Stopped::is(payload.as_ref()) => Err(Halt::Stopped),
        Err(payload) => Err(Halt::Failed(JobError::Failed(panic_text(payload.as_ref())))),
    }
}

fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    format!("panicked: {}", text.unwrap_or("no message"))
}

/// A mutex whose holder panicked still has whole data here: every change is a single assignment.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
