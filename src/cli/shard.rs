//! `bmv shard`: what a task of a cluster runs.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::Context;
use super::output::tell;
use super::status::{Failure, Status};
use crate::batch;
use crate::runner::cluster::worker::{End, Shard};
use crate::runner::{Progress, Settings};

/// Arguments of `bmv shard`.
#[derive(Debug, clap::Args)]
#[command(after_help = "A task of an array calls this; any other scheduler may, too.\n\n\
                        Exit status:\n  \
                        0 all blocks of the shard are published\n  \
                        64 the arguments are wrong\n  \
                        65 the definition is rejected, or a block fails and would again\n  \
                        75 it may succeed another time\n\n\
                        Example:\n  \
                        bmv shard --run /shared/cache/runs/KEY/1 --index 7 --threads 4")]
pub(super) struct ShardVerb {
    /// Folder of a submission, as `bmv run --engine slurm` made it
    #[arg(long, value_name = "DIR")]
    run: PathBuf,
    /// Index of the shard
    #[arg(long, value_name = "N")]
    index: usize,
    /// Threads
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// Name of this machine, for the record of the shard
    #[arg(long, value_name = "NAME", default_value = "")]
    node: String,
    /// How often the scheduler started the shard again, for its record
    #[arg(long, value_name = "N", default_value_t = 0)]
    restart: u64,
}

impl ShardVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let settings = Settings { threads: Some(self.threads), ..Settings::default() };
        let load = |pass: &Path| batch::cluster::plan_of(pass, &context.reading).map_err(|error| error.to_string());
        let task = (Some(self.node).filter(|name| !name.is_empty()), self.restart);
        let listener = Progress::on_standard_error();
        let (end, reason) = context.interrupts.counted(|signals| {
            let shard = Shard {
                folder: &self.run,
                index: self.index,
                task,
                settings,
                signals,
                listener: &listener,
                load: &load,
            };
            shard.run()
        });
        if let Some(reason) = reason {
            tell(&format!("shard {}: {reason}", self.index));
        }
        Ok(match end {
            End::Published => Status::Done,
            End::Usage => Status::ShardUsage,
            End::Rejected => Status::ShardRejected,
            End::Temporary => Status::ShardTemporary,
        })
    }
}
