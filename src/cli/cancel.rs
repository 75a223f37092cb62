//! `bmv cancel`.

use super::cluster::{RunArgument, scheduler};
use super::output::print;
use super::status::{Failure, Status};
use crate::document::counted;
use crate::runner::cluster::scheduler::SchedulerError;

/// Arguments of `bmv cancel`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Blocks that are there stay: the next `bmv run` computes the rest.\n\n\
                        Example:\n  \
                        bmv cancel 3f9c21aa0b7d")]
pub(super) struct Cancel {
    #[command(flatten)]
    run: RunArgument,
}

impl Cancel {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let folder = self.run.find()?;
        let scheduler = scheduler(&folder.record()?.engine)?;
        // First, so that nobody who follows the run submits it again.
        folder.set_cancelled(true)?;
        let refused = |error: SchedulerError| Failure::job(error.to_string());
        let mut cancelled = 0_u64;
        for submission in folder.submissions() {
            let (name, comment) = (folder.name(), folder.comment(submission.number));
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
