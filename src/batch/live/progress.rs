//! How far a round has come, for the page.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::batch::graph::in_study;
use crate::runner::{Event, Listener};

/// Hears the events of a run and says in words how it stands.
#[derive(Clone, Debug, Default)]
pub struct RoundProgress {
    jobs: Arc<Mutex<BTreeMap<String, Running>>>,
}

/// A job that runs.
#[derive(Clone, Debug, Default)]
struct Running {
    stage: String,
    blocks: usize,
    done: usize,
}

impl RoundProgress {
    /// A line for each job that runs.
    pub fn lines(&self) -> Vec<String> {
        let jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        let line = |(id, running): (&String, &Running)| {
            let job = in_study(id).replace('`', "");
            match running.blocks {
                0 => job,
                blocks => format!("{job}: {}, {} of {blocks}", running.stage, running.done),
            }
        };
        jobs.iter().map(line).collect()
    }

    fn change(&self, job: &str, change: impl FnOnce(&mut Running)) {
        change(self.jobs.lock().unwrap_or_else(PoisonError::into_inner).entry(job.to_owned()).or_default());
    }
}

impl Listener for RoundProgress {
    fn hear(&self, event: &Event) {
        match event {
            Event::JobStarted { job, .. } => self.change(job, |_| {}),
            Event::StageStarted { job, stage, blocks, .. } => {
                self.change(job, |running| {
                    *running = Running { stage: stage.clone(), blocks: *blocks, done: 0 };
                });
            }
            Event::BlockDone { job, .. } => self.change(job, |running| running.done += 1),
            Event::JobFinished { job, .. } | Event::JobFailed { job, .. } | Event::JobSkipped { job, .. } => {
                self.jobs.lock().unwrap_or_else(PoisonError::into_inner).remove(job);
            }
            _ => {}
        }
    }
}
