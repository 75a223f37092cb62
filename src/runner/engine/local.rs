//! The engine of this machine: a pool of threads of its own.
//!
//! Nothing waits inside the pool: each block is a task, the last block of a stage reduces it and starts the next, the last
//! job that another builds upon starts that one. So jobs and blocks of all jobs fill the threads together. Every finished
//! block is published at once, and so are the states that long ones leave on their way; a run that was killed begins where it stopped. A block that is left because the run was
//! asked to stop is one that was not begun. What the system does not let store (another user's cache, a full disk) is
//! used all the same, and the run says so once.
//!
//! Where blocks are computed elsewhere, a task whose block is not in the cache hands it over and ends; when it is said to
//! be there, the task is started again. All else is the same: keys, order of reduction, results.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use rayon::ScopeFifo;

use super::block::{Blocks, Halt, Working, caught, failure};
use super::elsewhere::{Elsewhere, Settled, Wanted};
use super::pool::pool;
use super::{Finished, Outcome, RunSummary, Settings, StopFlag, block_name};
use crate::job::stored::ResultDocument;
use crate::job::{Next, Stage};
use crate::runner::cache::{Cache, Kind};
use crate::runner::error::RunnerError;
use crate::runner::events::{Event, Listener};
use crate::runner::plan::{Plan, State};
use crate::runner::stored::{self, Stored};

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
    run_with(plan, cache, settings, stop, listener, None)
}

/// As [`run`]; blocks that are not in the cache are computed elsewhere, and jobs begun and reduced here.
///
/// # Errors
/// As [`run`], and those of [`Elsewhere::settled`].
pub fn run_elsewhere(
    plan: &Plan,
    cache: &Cache,
    settings: &Settings,
    stop: &StopFlag,
    listener: &dyn Listener,
    elsewhere: &dyn Elsewhere,
) -> Result<RunSummary, RunnerError> {
    run_with(plan, cache, settings, stop, listener, Some(elsewhere))
}

fn run_with(
    plan: &Plan,
    cache: &Cache,
    settings: &Settings,
    stop: &StopFlag,
    listener: &dyn Listener,
    elsewhere: Option<&dyn Elsewhere>,
) -> Result<RunSummary, RunnerError> {
    let threads = settings.threads();
    let pool = pool(settings, stop)?;

    let (states, damaged) = plan.survey(cache, settings.only.as_ref(), settings.force);
    for object in damaged {
        listener.hear(&Event::Damaged { object });
    }
    let count = |wanted: fn(&State) -> bool| states.iter().filter(|state| wanted(state)).count();
    let to_run = count(|state| *state == State::Missing);
    let cached = count(|state| matches!(state, State::Cached(_)));
    let engine = elsewhere.map(Elsewhere::name);
    listener.hear(&Event::RunStarted { to_run, cached, threads, engine });

    let run = Run::new(plan, cache, settings, stop, listener, elsewhere, &states);
    for (position, state) in states.into_iter().enumerate() {
        if let State::Cached(stored) = state {
            let (job, key) = (plan.nodes()[position].id.clone(), plan.keys()[position].clone());
            listener.hear(&Event::JobCached { job, key: key.clone() });
            let finished = Finished { key, stored, cached: true, blocks_run: 0, blocks_cached: 0 };
            run.slots[position].set(Outcome::Finished(finished));
        }
    }
    pool.in_place_scope_fifo(|scope| {
        for position in run.ready_at_once() {
            run.spawn(scope, move |run, scope| run.start(scope, position));
        }
        elsewhere.map_or(Ok(()), |elsewhere| run.follow(scope, elsewhere))
    })?;
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
    stop: &'a StopFlag,
    listener: &'a dyn Listener,
    slots: Vec<Slot>,
    blocks: Blocks<'a>,
    elsewhere: Option<&'a dyn Elsewhere>,
    /// Tasks that were started and have not ended.
    busy: AtomicUsize,
    /// Blocks that were handed over, by ticket.
    handed: Mutex<Handed>,
}

#[derive(Default)]
struct Handed {
    next: usize,
    blocks: BTreeMap<usize, (Arc<Active>, Arc<Running>, usize)>,
}

/// A job that runs.
struct Active {
    position: usize,
    working: Working,
    blocks_run: AtomicUsize,
    blocks_cached: AtomicUsize,
}

/// A stage that runs.
struct Running {
    stage: Arc<Stage>,
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
        elsewhere: Option<&'a dyn Elsewhere>,
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
        let blocks = Blocks::new(cache, listener, settings.keep_every()).forced(settings.force);
        let (busy, handed) = (AtomicUsize::new(0), Mutex::default());
        Self { plan, stop, listener, slots, blocks, elsewhere, busy, handed }
    }

    /// Starts a task.
    fn spawn<'s>(&'s self, scope: &ScopeFifo<'s>, task: impl FnOnce(&'s Self, &ScopeFifo<'s>) + Send + 's) {
        self.busy.fetch_add(1, Ordering::AcqRel);
        scope.spawn_fifo(move |scope| {
            task(self, scope);
            // After those that it started were counted.
            self.busy.fetch_sub(1, Ordering::AcqRel);
        });
    }

    /// Waits for the blocks that are computed elsewhere, until nothing is left to wait for.
    fn follow<'s>(&'s self, scope: &ScopeFifo<'s>, elsewhere: &dyn Elsewhere) -> Result<(), RunnerError> {
        loop {
            // In this order: a task that ended in between has handed over what it had to.
            let is_idle = self.busy.load(Ordering::Acquire) == 0;
            let waits = !lock(&self.handed).blocks.is_empty();
            if self.stop.is_stopped() || (is_idle && !waits) {
                return Ok(());
            }
            let Some(settled) = elsewhere.settled(is_idle)? else { return Ok(()) };
            for Settled { ticket, result } in settled {
                let Some((active, running, index)) = lock(&self.handed).blocks.remove(&ticket) else { continue };
                self.spawn(scope, move |run, scope| match result {
                    Ok(()) => run.block(scope, active, &running, index),
                    Err(error) => {
                        running.fail(index, error);
                        run.ended(scope, active, &running);
                    }
                });
            }
        }
    }

    /// Hands a block over that is not in the cache.
    fn hand_over(&self, elsewhere: &dyn Elsewhere, active: Arc<Active>, running: Arc<Running>, index: usize) {
        let (working, stage) = (&active.working, Arc::clone(&running.stage));
        let (job, owner, name) = (working.id.clone(), working.key.clone(), block_name(&working.key, &stage, index));
        let ticket = {
            let mut handed = lock(&self.handed);
            let ticket = handed.next;
            handed.next += 1;
            handed.blocks.insert(ticket, (active, running, index));
            ticket
        };
        elsewhere.want(Wanted { ticket, job, owner, stage, index, name });
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
                let next = active.working.guarded(None, None, |job| job.begin());
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
            .map_err(|halt| Outcome::from(halt.at(|source| failure(&node.id, None, None, source))))?;
        Ok(Arc::new(Active {
            position,
            working: Working::new(node.id.clone(), self.plan.keys()[position].clone(), job),
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
                Ok(Next::Done(result)) => {
                    let outcome = self.publish(&active, result);
                    let outcome = outcome.map_or_else(|error| Outcome::Failed(Arc::new(error)), Outcome::Finished);
                    return self.end(scope, active.position, outcome);
                }
                Ok(Next::Stage(stage)) => {
                    let (job, blocks, is_last) = (self.id(active.position), stage.inputs.len(), stage.is_last);
                    self.listener.hear(&Event::StageStarted { job, stage: stage.name.clone(), blocks, is_last });
                    if blocks == 0 {
                        next = active.working.guarded(Some(&stage.name), None, |job| job.reduce(&stage, Vec::new()));
                        continue;
                    }
                    let running = Arc::new(Running {
                        stage: Arc::new(stage),
                        outputs: Mutex::new(vec![None; blocks]),
                        remaining: AtomicUsize::new(blocks),
                        failure: Mutex::new(None),
                    });
                    for index in 0..blocks {
                        let (active, running) = (Arc::clone(&active), Arc::clone(&running));
                        self.spawn(scope, move |run, scope| run.block(scope, active, &running, index));
                    }
                    return;
                }
            }
        }
    }

    /// Takes a block from the cache or runs it, here or elsewhere; the last one of the stage goes on.
    fn block<'s>(&'s self, scope: &ScopeFifo<'s>, active: Arc<Active>, running: &Arc<Running>, index: usize) {
        let is_moot = lock(&running.failure).as_ref().is_some_and(|(failed, _)| *failed < index);
        if !is_moot && !self.stop.is_stopped() {
            let found = self.blocks.find(&active.working.key, &running.stage, index);
            if let (None, Some(elsewhere)) = (&found, self.elsewhere) {
                return self.hand_over(elsewhere, active, Arc::clone(running), index);
            }
            match self.output(&active, &running.stage, index, found) {
                Ok(output) => lock(&running.outputs)[index] = Some(output),
                Err(Halt::Stopped) => {}
                Err(Halt::Failed(error)) => running.fail(index, error),
            }
        }
        self.ended(scope, active, running);
    }

    /// Notes that one more block of a stage has ended; after the last one the job goes on.
    fn ended<'s>(&'s self, scope: &ScopeFifo<'s>, active: Arc<Active>, running: &Running) {
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
        let next = active.working.guarded(Some(&stage.name), None, |job| job.reduce(stage, outputs));
        self.advance(scope, active, next);
    }

    /// The output of a block that was found, or is run now.
    fn output(
        &self,
        active: &Active,
        stage: &Stage,
        index: usize,
        found: Option<Vec<u8>>,
    ) -> Result<Vec<u8>, Halt<RunnerError>> {
        let cached = found.is_some();
        let (output, counted) = match found {
            Some(output) => (output, &active.blocks_cached),
            None => (self.blocks.run(&active.working, stage, index)?, &active.blocks_run),
        };
        counted.fetch_add(1, Ordering::Relaxed);
        let (job, stage) = (active.working.id.clone(), stage.name.clone());
        self.listener.hear(&Event::BlockDone { job, stage, index, cached });
        Ok(output)
    }

    fn publish(&self, active: &Active, result: ResultDocument) -> Result<Finished, RunnerError> {
        let (job, key) = (self.id(active.position), self.plan.keys()[active.position].clone());
        let bytes = stored::bytes(&result, &job)?;
        // Of a long result there is one copy at a time.
        drop(result);
        self.blocks.store(Kind::Result, &key, &key, &bytes)?;
        let finished = Finished {
            key,
            stored: Stored::from_bytes(&bytes, &job)?,
            cached: false,
            blocks_run: active.blocks_run.load(Ordering::Relaxed),
            blocks_cached: active.blocks_cached.load(Ordering::Relaxed),
        };
        self.listener.hear(&Event::JobFinished {
            job,
            kind: active.working.job.kind().to_owned(),
            key: finished.key.clone(),
            blocks_run: finished.blocks_run,
            blocks_cached: finished.blocks_cached,
            work_s: active.working.work_s(),
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
                self.spawn(scope, move |run, scope| run.start(scope, next));
            }
        }
    }
}

impl Running {
    /// Notes that a block failed.
    fn fail(&self, index: usize, error: RunnerError) {
        let mut failure = lock(&self.failure);
        if failure.as_ref().is_none_or(|(failed, _)| index < *failed) {
            *failure = Some((index, error));
        }
    }
}

/// A mutex whose holder panicked still has whole data here: every change is a single assignment.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
