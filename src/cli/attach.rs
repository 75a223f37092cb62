//! `bmv attach`.

use super::Context;
use super::cluster::{RunArgument, resume};
use super::status::{Failure, Status};
use crate::runner::cluster::Mode;

/// Arguments of `bmv attach`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
                        bmv attach 3f9c21aa0b7d")]
pub(super) struct Attach {
    #[command(flatten)]
    run: RunArgument,
}

impl Attach {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        resume(&self.run, Mode::Wait, false, context)
    }
}
