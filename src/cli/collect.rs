//! `bmv collect`.

use super::Context;
use super::cluster::{RunArgument, resume};
use super::status::{Failure, Status};
use crate::runner::cluster::Mode;

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

impl Collect {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let mode = if self.finish_on_cluster { Mode::Detach } else { Mode::Collect };
        resume(&self.run, mode, self.finish_on_cluster, context)
    }
}
