//! `bmv attach`, `bmv collect` and `bmv cancel`: a run on a cluster that was left.

use super::Context;
use super::cluster::{RunArgument, follow, scheduler, status};
use super::output::{print, tell};
use super::run::outcome;
use super::status::{Failure, Status};
use crate::batch;
use crate::document::counted;
use crate::runner::Settings;
use crate::runner::cluster::{Mode, Options, RunRecord};

/// Arguments of `bmv attach`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
                        bmv attach 3f9c21aa0b7d")]
pub(super) struct Attach {
    #[command(flatten)]
    run: RunArgument,
}

/// Arguments of `bmv collect`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Nothing is submitted, unless --finish-on-cluster asks for it: then the next stage, or what is missing, is, and \
                        another job of the cluster goes on after that.\n\n\
                        Example:\n  \
                        bmv collect 3f9c21aa0b7d"
)]
pub(super) struct Collect {
    #[command(flatten)]
    run: RunArgument,
    /// Submit what is missing, and a job that goes on then
    #[arg(long)]
    finish_on_cluster: bool,
}

/// Arguments of `bmv cancel`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Blocks that are there stay: the next `bmv run` computes the rest.\n\n\
                        Example:\n  \
                        bmv cancel 3f9c21aa0b7d")]
pub(super) struct Cancel {
    #[command(flatten)]
    run: RunArgument,
}

/// Goes on with a run.
fn resume(run: &RunArgument, mode: Mode, finish_on_cluster: bool, context: &Context) -> Result<Status, Failure> {
    let folder = run.find()?;
    let record = folder.record()?;
    let options = Options { finish_on_cluster, ..record.options };
    let record = RunRecord { options, ..record };
    let (prepared, is_same) = batch::cluster::resume(&folder, &record, &context.reading)?;
    if !is_same {
        tell("the study has changed since it was submitted; this is the run of what it was then");
    }
    let executed = follow(prepared, &folder, &record, mode, Settings::default(), context)?;
    print(&outcome(&executed, context.fold)?)?;
    Ok(status(&executed, mode == Mode::Detach))
}

impl Attach {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        resume(&self.run, Mode::Wait, false, context)
    }
}

impl Collect {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let mode = if self.finish_on_cluster { Mode::Detach } else { Mode::Collect };
        resume(&self.run, mode, self.finish_on_cluster, context)
    }
}

impl Cancel {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let folder = self.run.find()?;
        let scheduler = scheduler(&folder.record()?.engine)?;
        // First, so that nobody who follows the run submits it again.
        folder.set_cancelled(true)?;
        let mut cancelled = 0_u64;
        for submission in folder.submissions() {
            let (name, comment) = (folder.name(), folder.comment(submission.number));
            let refused = |error: crate::runner::cluster::scheduler::SchedulerError| Failure::job(error.to_string());
            let job = match submission.job() {
                Some(job) => Some(job),
                None => scheduler.find(&name, &comment).map_err(refused)?,
            };
            let Some(job) = job else { continue };
            if !scheduler.tasks(&job, &name).map_err(refused)?.is_empty() {
                scheduler.cancel(&job).map_err(refused)?;
                cancelled += 1;
            }
        }
        print(&format!("{} cancelled; blocks that are there stay\n", counted(cancelled, "array")))?;
        Ok(Status::Done)
    }
}
