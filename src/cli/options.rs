//! Options that several verbs share.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use super::execute::Executed;
use super::output::{escaped, tell};
use super::status::{Failure, Status};
use super::studies;
use crate::report::{required, terminal};
use crate::runner::{Cache, Settings};

/// Where the cache lies.
#[derive(Args, Clone, Debug)]
pub struct CacheOption {
    /// Folder of the cache [default: .bmv/cache]
    #[arg(long = "cache", value_name = "DIR")]
    pub folder: Option<PathBuf>,
}

impl CacheOption {
    /// The cache.
    pub fn cache(&self) -> Cache {
        Cache::new(self.folder.as_deref().unwrap_or(Path::new(".bmv/cache")))
    }

    /// Folder of the event logs: beside the cache, or in the one that was named.
    pub fn events(&self) -> PathBuf {
        self.folder.as_ref().map_or_else(|| PathBuf::from(".bmv/events"), |folder| folder.join("events"))
    }
}

/// How jobs run.
#[derive(Args, Clone, Debug)]
pub struct RunOptions {
    /// Threads to use; results do not depend on it [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Run again what is in the cache, and compare
    #[arg(long)]
    force: bool,
    /// The cache.
    #[command(flatten)]
    pub cache: CacheOption,
}

/// How jobs run where `--force` means something else.
#[derive(Args, Clone, Debug)]
pub struct CachedRunOptions {
    /// Threads to use; results do not depend on it [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// The cache.
    #[command(flatten)]
    pub cache: CacheOption,
}

impl From<CachedRunOptions> for RunOptions {
    fn from(options: CachedRunOptions) -> Self {
        Self { threads: options.threads, force: false, cache: options.cache }
    }
}

/// Whether what is required decides the exit status.
#[derive(Args, Clone, Copy, Debug)]
pub struct RequireOption {
    /// End with status 1 where a requirement is not met by the given design, or nothing is required
    #[arg(long)]
    pub require: bool,
}

impl RequireOption {
    /// The status in the light of what is required: what speaks against the results is told.
    ///
    /// # Errors
    /// A result that cannot be read.
    pub fn judge(self, executed: &Executed, status: Status) -> Result<Status, Failure> {
        if !self.require || status != Status::Done {
            return Ok(status);
        }
        let (mut judged, mut is_met) = (0, true);
        for pass in &executed.passes {
            let shown = escaped(&pass.shown);
            let report = studies::view(pass, executed)?;
            for job in &report.results {
                for standing in required::standings(&job.result) {
                    judged += 1;
                    if !standing.is_met {
                        is_met = false;
                        tell(&format!(
                            "not met: {shown}: {}: {}",
                            escaped(&job.name),
                            terminal::plain(&standing.words)
                        ));
                    }
                }
            }
            for reason in &report.warnings {
                is_met = false;
                tell(&format!("not met: {shown}: {}", terminal::plain(reason)));
            }
        }
        if judged == 0 {
            // A check of nothing must not look as if all were well.
            tell("nothing is required: no job here judges a requirement");
        }
        Ok(if judged > 0 && is_met { status } else { Status::CheckFailed })
    }
}

impl RunOptions {
    /// Whether what is in the cache is run again.
    pub fn is_forced(&self) -> bool {
        self.force
    }

    /// Settings of a run of all jobs.
    pub fn settings(&self) -> Settings {
        Settings { threads: self.threads, force: self.force, only: None }
    }
}

/// Which passes.
#[derive(Args, Clone, Debug)]
pub struct PathsArgument {
    /// Pass files, study folders, or folders of such
    #[arg(value_name = "PATH", default_value = "studies")]
    pub paths: Vec<PathBuf>,
}
