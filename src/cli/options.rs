//! Options that several verbs share.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use super::output::{escaped, shown, tell};
use super::status::{Failure, Status};
use crate::batch::{self, Executed, LoadedPass};
use crate::report::section::objection;
use crate::report::{required, terminal};
use crate::runner::{Cache, Settings};
use crate::study::Project;
use crate::study::project::default_path;

/// Where the cache lies.
#[derive(Args, Clone, Debug)]
pub struct CacheOption {
    /// Folder of the cache [default: .bmv/cache of the study's project]
    #[arg(long = "cache", value_name = "DIR")]
    pub folder: Option<PathBuf>,
}

impl CacheOption {
    /// The cache: the one that was named, else that of the project of these passes.
    pub fn cache(&self, passes: &[LoadedPass]) -> Cache {
        self.cache_of(&project(passes))
    }

    /// The cache: the one that was named, else that of this project.
    pub fn cache_of(&self, project: &Project) -> Cache {
        Cache::new(self.folder.clone().unwrap_or_else(|| project.cache()))
    }

    /// Folder of the event logs: beside the cache, or in the one that was named.
    pub fn events(&self, passes: &[LoadedPass]) -> PathBuf {
        self.folder.as_ref().map_or_else(|| project(passes).events(), |folder| folder.join("events"))
    }

    /// What to tell where passes of several projects share the cache of the first.
    pub fn shared(&self, passes: &[LoadedPass]) -> Option<String> {
        let of_first = project(passes);
        let is_shared = self.folder.is_none() && passes.iter().any(|pass| pass.project != of_first);
        is_shared.then(|| {
            let folder = of_first.cache();
            format!("the studies lie in several projects: all use the cache `{}` (or --cache DIR)", shown(&folder))
        })
    }
}

/// The project of the first of these passes; where there is none, the one in which the program is called.
fn project(passes: &[LoadedPass]) -> Project {
    passes.first().map_or_else(Project::here, |pass| pass.project.clone())
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
    /// The status in the light of what is required: what speaks against the results is stated.
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
            let report = batch::view(pass, executed)?;
            for job in &report.results {
                for standing in required::standings(job) {
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
            if let Some(objection) = objection(&report) {
                is_met = false;
                tell(&format!("not met: {shown}: {}", terminal::sentence(&objection)));
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

    /// The same, running again what is in the cache.
    pub fn forced(self) -> Self {
        Self { force: true, ..self }
    }

    /// Settings of a run of all jobs.
    pub fn settings(&self) -> Settings {
        Settings { threads: self.threads, force: self.force, ..Settings::default() }
    }
}

/// Which passes.
#[derive(Args, Clone, Debug)]
pub struct PathsArgument {
    /// Pass files, study folders, or folders of such; in a study the default is that study
    #[arg(value_name = "PATH", default_values_os_t = vec![default_path()])]
    pub paths: Vec<PathBuf>,
}
