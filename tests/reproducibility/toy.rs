//! A job of two stages whose second depends on the first, with sums whose last bits depend on their order.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bmv::job::{Done, Job, JobError, Parts, Runnable, Step};
use bmv::runner::engine::local;
use bmv::runner::{Cache, Event, Listener, Node, Plan, Ready, RunSummary, Settings, StopFlag, Task};
use serde_json::{Value, json};

/// What a toy does wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fault {
    #[default]
    None,
    PanicInBlocks,
    FailInReduce,
    /// The result depends on how often it was computed.
    Counts,
}

/// Adds 1/i for i below `terms` in blocks, then in a second, finer pass as many blocks as the first sum says.
#[derive(Default)]
pub struct Harmonic {
    pub terms: usize,
    pub version: u32,
    pub fault: Fault,
    /// Blocks that were run, over all runs.
    pub blocks_run: AtomicUsize,
    /// Asked to stop when this many blocks were run.
    pub stop_after: Option<(usize, StopFlag)>,
    pub reduce_panics: AtomicBool,
}

impl Harmonic {
    pub fn new(terms: usize) -> Self {
        Self { terms, ..Self::default() }
    }
}

impl Job for Harmonic {
    /// Whether it is the finer pass.
    type State = bool;
    type Input = usize;
    type Partial = f64;
    type Output = Value;
    fn kind(&self) -> &'static str {
        "harmonic"
    }
    fn algorithm_version(&self) -> u32 {
        self.version
    }
    fn identity(&self) -> Value {
        json!({ "terms": self.terms })
    }
    fn begin(&self) -> Result<Step<Self>, JobError> {
        let inputs = (0..self.terms).step_by(100).collect();
        Ok(Step::Blocks { stage: "coarse".into(), state: false, inputs })
    }
    fn block(&self, is_fine: &bool, start: usize, _parts: &dyn Parts) -> Result<f64, JobError> {
        assert!(self.fault != Fault::PanicInBlocks || start < 300, "term {start} is too large");
        let runs = self.blocks_run.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some((count, stop)) = &self.stop_after
            && runs >= *count
        {
            stop.stop();
        }
        let scale = if *is_fine { 7.0 } else { 1.0 };
        let mut sum: f64 = (start..(start + 100).min(self.terms)).map(|i| scale / (i as f64 + 1.0)).sum();
        if self.fault == Fault::Counts {
            sum += runs as f64;
        }
        Ok(sum)
    }
    fn reduce(&self, is_fine: bool, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        assert!(!self.reduce_panics.load(Ordering::Relaxed), "the reduction was killed");
        if self.fault == Fault::FailInReduce {
            return Err(JobError::Failed("the sum does not converge".into()));
        }
        let sum = blocks.iter().fold(0.0, |sum, (_, own)| sum + own);
        if !is_fine {
            let inputs = (0..sum as usize + 3).map(|start| start * 50).collect();
            return Ok(Step::Blocks { stage: "fine".into(), state: true, inputs });
        }
        Ok(Step::Done(Box::new(json!({ "sum": sum, "blocks": blocks.len(), "whole": 2.0 }))))
    }
}

/// A job whose number of terms comes from the results of others.
pub struct Following;

impl Task for Following {
    fn kind(&self) -> &'static str {
        "following"
    }
    fn algorithm_version(&self) -> u32 {
        1
    }
    fn identity(&self) -> Value {
        json!({})
    }
    fn prepare(&self, upstream: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        let blocks: Option<Vec<u64>> = upstream.iter().map(|value| value["blocks"].as_u64()).collect();
        let blocks = blocks.ok_or_else(|| JobError::Failed("upstream without `blocks`".into()))?;
        Ok(Arc::new(Harmonic::new(100 * blocks.iter().sum::<u64>() as usize)))
    }
}

/// Remembers events.
#[derive(Default)]
pub struct Heard(pub Mutex<Vec<Event>>);

impl Listener for Heard {
    fn hear(&self, event: &Event) {
        self.0.lock().expect("no panic while held").push(event.clone());
    }
}

pub fn node(id: &str, job: Arc<dyn Runnable>) -> Node {
    Node { id: id.into(), name: id.into(), seed: 7, from: Vec::new(), task: Box::new(Ready(job)) }
}

pub fn following(id: &str, from: &[&str]) -> Node {
    let from = from.iter().map(|&id| id.to_owned()).collect();
    Node { id: id.into(), name: id.into(), seed: 7, from, task: Box::new(Following) }
}

pub fn settings(threads: usize) -> Settings {
    let threads = std::num::NonZeroUsize::new(threads);
    Settings { threads, keep_every: Some(std::time::Duration::ZERO), ..Settings::default() }
}

pub fn run(plan: &Plan, cache: &Cache, threads: usize) -> RunSummary {
    local::run(plan, cache, &settings(threads), &StopFlag::default(), &Heard::default()).expect("threads start")
}

/// A plan of one toy called `sum`.
pub fn single(job: &Arc<Harmonic>) -> Plan {
    Plan::new(vec![node("sum", Arc::clone(job) as Arc<dyn Runnable>)]).expect("one job")
}
