//! What the engine asks of a scheduler, whichever it is: arrays with an index, one name, one cancellation.

use std::path::Path;

use thiserror::Error;

use super::options::Options;

/// Why a scheduler did not do what it was asked.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SchedulerError {
    /// It cannot be asked now: nothing is known.
    #[error("{0}")]
    Unreachable(String),
    /// It says no.
    #[error("{0}")]
    Refused(String),
}

/// What a cluster allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Most tasks of an array.
    pub array: Option<usize>,
    /// Most jobs that the scheduler holds, each task counted.
    pub jobs: Option<usize>,
    /// Processors of the machines that may be used.
    pub processors: Option<usize>,
    /// Whether how tasks ended is kept for long; nothing where it is not known.
    pub keeps_accounts: Option<bool>,
}

/// An array, or a single job, that is to be submitted.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Its name.
    pub name: &'a str,
    /// By which it is known again, beside the name.
    pub comment: &'a str,
    /// Tasks, numbered from 0; nothing = one job that is no array.
    pub tasks: Option<usize>,
    /// Where it runs. It is there.
    pub folder: &'a Path,
    /// Where its tasks write what they say. It is there.
    pub log: &'a Path,
    /// The script.
    pub script: &'a Path,
    /// Nodes that are not used, beside those of the options.
    pub exclude: &'a [String],
    /// The job after whose end it starts.
    pub after: Option<&'a str>,
    /// Everything else.
    pub options: &'a Options,
}

/// A task that has not ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Its index in the array.
    pub index: usize,
    /// Why it waits, in the scheduler's word; nothing if it does not.
    pub waits: Option<String>,
    /// Where it runs.
    pub node: Option<String>,
}

/// How a task ended, as long as the scheduler remembers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ending {
    /// Its index in the array.
    pub index: usize,
    /// The scheduler's word.
    pub state: String,
    /// Exit code and signal, as the scheduler writes them.
    pub code: String,
    /// Where it ran.
    pub node: Option<String>,
}

impl Ending {
    /// Whether somebody cancelled it.
    pub fn is_cancelled(&self) -> bool {
        self.state.starts_with("CANCELLED")
    }
}

/// Why a task waits, in the eyes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// For its turn.
    Turn,
    /// For a time after which it was put off, because its machine was lost.
    Delay,
    /// For something that will not come by itself.
    Lasting,
}

/// Names of environment variables of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variables {
    /// Its index in the array.
    pub index: &'static str,
    /// The scheduler's name of the machine.
    pub node: &'static str,
    /// How often it was started again.
    pub restart: &'static str,
}

/// A scheduler of jobs.
pub trait Scheduler: Sync {
    /// What people call it.
    fn name(&self) -> &'static str;

    /// The variables that tell a task about itself.
    fn variables(&self) -> Variables;

    /// What the cluster allows.
    ///
    /// # Errors
    /// It is not here, or cannot be asked.
    fn limits(&self, options: &Options) -> Result<Limits, SchedulerError>;

    /// The job that was submitted under this name and comment and has not ended.
    ///
    /// # Errors
    /// It cannot be asked.
    fn find(&self, name: &str, comment: &str) -> Result<Option<String>, SchedulerError>;

    /// Submits, and gives the job's id.
    ///
    /// # Errors
    /// It refuses, or whether it accepted is not known.
    fn submit(&self, request: &Request<'_>) -> Result<String, SchedulerError>;

    /// The tasks of an array that have not ended. None: all have, or nothing is known of it any more.
    ///
    /// # Errors
    /// It cannot be asked.
    fn tasks(&self, job: &str, name: &str) -> Result<Vec<Task>, SchedulerError>;

    /// What a task's reason to wait means.
    fn wait(&self, reason: &str) -> Wait;

    /// How tasks of an array ended, as far as it remembers.
    fn endings(&self, job: &str) -> Vec<Ending>;

    /// Lets a task that was put off start now.
    fn hasten(&self, job: &str, index: usize);

    /// Ends all tasks of an array.
    ///
    /// # Errors
    /// It cannot be asked.
    fn cancel(&self, job: &str) -> Result<(), SchedulerError>;
}
