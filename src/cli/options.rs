//! Options that several verbs share.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

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

impl RunOptions {
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
