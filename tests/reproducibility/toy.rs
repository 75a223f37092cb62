//! A job of two stages whose second depends on the first, with sums whose last bits depend on their order.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bmv::job::{Job, JobError, Step};
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

fn number(bytes: &[u8]) -> Result<f64, JobError> {
    let text = std::str::from_utf8(bytes).map_err(|e| JobError::Failed(e.to_string()))?;
    text.parse().map_err(|_| JobError::Failed(format!("`{text}` is no number")))
}

impl Job for Harmonic {
    fn kind(&self) -> &'static str {
        "harmonic"
    }
    fn algorithm_version(&self) -> u32 {
        self.version
    }
    fn identity(&self) -> Value {
        json!({ "terms": self.terms })
    }
    fn begin(&self) -> Result<Step, JobError> {
        let inputs = (0..self.terms).step_by(100).map(|start| start.to_string().into_bytes()).collect();
        Ok(Step::Blocks { stage: "coarse".into(), inputs })
    }
    fn block(&self, stage: &str, input: &[u8]) -> Result<Vec<u8>, JobError> {
        let start = number(input)? as usize;
        assert!(self.fault != Fault::PanicInBlocks || start < 300, "term {start} is too large");
        let runs = self.blocks_run.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some((count, stop)) = &self.stop_after
            && runs >= *count
        {
            stop.stop();
        }
        let scale = if stage == "fine" { 7.0 } else { 1.0 };
        let mut sum: f64 = (start..(start + 100).min(self.terms)).map(|i| scale / (i as f64 + 1.0)).sum();
        if self.fault == Fault::Counts {
            sum += runs as f64;
        }
        Ok(sum.to_string().into_bytes())
    }
    fn reduce(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        assert!(!self.reduce_panics.load(Ordering::Relaxed), "the reduction of {stage} was killed");
        assert_eq!(inputs.len(), outputs.len());
        if self.fault == Fault::FailInReduce {
            return Err(JobError::Failed("the sum does not converge".into()));
        }
        let mut sum = 0.0;
        for output in outputs {
            sum += number(output)?;
        }
        if stage == "coarse" {
            let inputs = (0..sum as usize + 3).map(|start| (start * 50).to_string().into_bytes()).collect();
            return Ok(Step::Blocks { stage: "fine".into(), inputs });
        }
        Ok(Step::Done(json!({ "sum": sum, "blocks": outputs.len(), "whole": 2.0 })))
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
    fn prepare(&self, upstream: &[Arc<Value>]) -> Result<Arc<dyn Job>, JobError> {
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

pub fn node(id: &str, job: Arc<dyn Job>) -> Node {
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
    Plan::new(vec![node("sum", Arc::clone(job) as Arc<dyn Job>)]).expect("one job")
}
