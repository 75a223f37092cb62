//! Single blocks: found in the cache or run and stored, whoever asks for them. Code of jobs is called here alone: it is
//! measured, and a panic or an error becomes one that names the place.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::{Outcome, block_name};
use crate::document::hash::sha256;
use crate::job::{JobError, Parts, Runnable, Stage};
use crate::runner::cache::{Cache, Kind, Lookup};
use crate::runner::error::RunnerError;
use crate::runner::events::{Event, Listener};
use crate::runner::key::{Key, block_key, shared_key};
use crate::watch::{self, Share, Stopped};

/// A job whose code is called.
pub(in crate::runner) struct Working {
    /// What people call it.
    pub id: String,
    /// Its key.
    pub key: Key,
    /// The job.
    pub job: Arc<dyn Runnable>,
    work_ns: AtomicU64,
}

impl Working {
    /// A job that has not worked yet.
    pub fn new(id: String, key: Key, job: Arc<dyn Runnable>) -> Self {
        Self { id, key, job, work_ns: AtomicU64::new(0) }
    }

    /// Time spent in its code, summed over threads, seconds.
    pub fn work_s(&self) -> f64 {
        self.work_ns.load(Ordering::Relaxed) as f64 * 1e-9
    }

    /// Calls its code.
    pub fn guarded<T>(
        &self,
        stage: Option<&str>,
        block: Option<usize>,
        call: impl FnOnce(&dyn Runnable) -> Result<T, JobError>,
    ) -> Result<T, Halt<RunnerError>> {
        let begin = Instant::now();
        let result = caught(|| call(self.job.as_ref()));
        let elapsed_ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.work_ns.fetch_add(elapsed_ns, Ordering::Relaxed);
        result.map_err(|halt| halt.at(|source| failure(&self.id, stage, block, source)))
    }
}

/// A failure at its place.
pub(in crate::runner) fn failure(id: &str, stage: Option<&str>, block: Option<usize>, source: JobError) -> RunnerError {
    RunnerError::Job { job: id.to_owned(), stage: stage.map(str::to_owned), block, source }
}

/// Finds blocks, or runs and stores them.
pub(in crate::runner) struct Blocks<'a> {
    cache: &'a Cache,
    listener: &'a dyn Listener,
    /// Run what is in the cache too.
    force: bool,
    /// How long a block runs before it keeps its state.
    keep_every: Duration,
    /// Whether what cannot be stored is a failure.
    must_store: bool,
    /// Whether it was reported that something could not be stored.
    reported_not_stored: AtomicBool,
}

impl<'a> Blocks<'a> {
    /// Uses what is in the cache, and goes on where nothing can be stored.
    pub fn new(cache: &'a Cache, listener: &'a dyn Listener, keep_every: Duration) -> Self {
        Self {
            cache,
            listener,
            force: false,
            keep_every,
            must_store: false,
            reported_not_stored: AtomicBool::new(false),
        }
    }

    /// The same, running what is in the cache too.
    pub fn forced(self, force: bool) -> Self {
        Self { force, ..self }
    }

    /// The same for a run whose outputs nobody sees but in the cache.
    pub fn storing(self) -> Self {
        Self { must_store: true, ..self }
    }

    /// The output of a block, if it is in the cache and may be taken from there.
    pub fn find(&self, owner: &Key, stage: &Stage, index: usize) -> Option<Vec<u8>> {
        if self.force { None } else { self.found(block_name(owner, stage, index)) }
    }

    fn found(&self, name: Key) -> Option<Vec<u8>> {
        self.found_as(Kind::Block, name)
    }

    fn found_as(&self, kind: Kind, name: Key) -> Option<Vec<u8>> {
        match self.cache.get(kind, &name) {
            Lookup::Found(bytes) => Some(bytes),
            Lookup::Absent => None,
            Lookup::Damaged => {
                self.listener.hear(&Event::Damaged { object: name });
                None
            }
        }
    }

    /// Runs a block and stores its output.
    pub fn run(&self, working: &Working, stage: &Stage, index: usize) -> Result<Vec<u8>, Halt<RunnerError>> {
        let share = Share::default();
        self.listener.block_runs(&working.id, index, &share);
        let (last, refused) = (Cell::new(Instant::now()), RefCell::default());
        let parts = KeptParts { blocks: self, owner: &working.key, stage, index, last, refused };
        let run = |job: &dyn Runnable| watch::with_share(&share, || job.block(stage, index, &parts));
        let output = working.guarded(Some(&stage.name), Some(index), run)?;
        if let Some(error) = parts.refused.take() {
            return Err(Halt::Failed(error));
        }
        let name = block_name(&working.key, stage, index);
        self.store(Kind::Block, &working.key, &name, &output).map_err(Halt::Failed)?;
        Ok(output)
    }

    /// Stores an object where the system lets it; only other bytes for the same key are an error, unless it must be stored.
    pub fn store(&self, kind: Kind, owner: &Key, name: &Key, payload: &[u8]) -> Result<(), RunnerError> {
        match self.cache.put(kind, owner, name, payload) {
            Err(error @ RunnerError::File { .. }) if !self.must_store => {
                if !self.reported_not_stored.swap(true, Ordering::Relaxed) {
                    self.listener.hear(&Event::NotStored { reason: error.to_string() });
                }
                Ok(())
            }
            stored => stored,
        }
    }
}

/// The states of a block that runs, as objects of the cache.
struct KeptParts<'r, 'a> {
    blocks: &'r Blocks<'a>,
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
        let determining = [state.sha256(), sha256(&inputs[self.index])];
        block_key(self.owner, &format!("{name}, part {part}"), self.index, determining)
    }
}

impl Parts for KeptParts<'_, '_> {
    fn find(&self, part: u64) -> Option<Vec<u8>> {
        if self.blocks.force { None } else { self.blocks.found(self.name(part)) }
    }

    fn is_due(&self) -> bool {
        self.last.get().elapsed() >= self.blocks.keep_every
    }

    fn keep(&self, part: u64, state: &[u8]) {
        self.last.set(Instant::now());
        if let Err(error) = self.blocks.store(Kind::Block, self.owner, &self.name(part), state) {
            self.refused.replace(Some(error));
        }
    }

    fn shared(&self, of: &[u8]) -> Option<Vec<u8>> {
        if self.blocks.force { None } else { self.blocks.found_as(Kind::Run, shared_key(of)) }
    }

    fn share(&self, of: &[u8], found: &[u8]) {
        if let Err(error) = self.blocks.store(Kind::Run, self.owner, &shared_key(of), found) {
            self.refused.replace(Some(error));
        }
    }
}

/// Why a job's code gave nothing.
pub(in crate::runner) enum Halt<E> {
    /// The run was asked to stop.
    Stopped,
    Failed(E),
}

impl<E> Halt<E> {
    /// The same with the place of a failure.
    pub fn at<F>(self, place: impl FnOnce(E) -> F) -> Halt<F> {
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
pub(in crate::runner) fn caught<T>(call: impl FnOnce() -> Result<T, JobError>) -> Result<T, Halt<JobError>> {
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
