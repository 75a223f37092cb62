//! What can go wrong while jobs are planned, run and stored.

use std::path::PathBuf;

use thiserror::Error;

use crate::job::JobError;

/// An error of the runner.
#[derive(Debug, Error)]
pub enum RunnerError {
    /// The system refused a file operation (full disk, no permission, ...).
    #[error("cannot {action} `{}`: {source}", path.display())]
    File {
        /// What was tried, as in "write".
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The same key was computed twice with different bytes. Both are kept.
    #[error(
        "computed `{name}` again and got other bytes than those stored at `{}`; the new ones are kept at `{}`: \
         this is a bug in the job (its result depends on something outside its key)",
        stored.display(), kept.display()
    )]
    Nondeterministic {
        /// Name of the object: key of a job or identity of a block.
        name: String,
        /// The object that was there.
        stored: PathBuf,
        /// Where the other bytes lie.
        kept: PathBuf,
    },
    /// A job gave no result.
    #[error("job `{job}`{}: {source}", place(stage.as_deref(), *block))]
    Job {
        /// Id of the job.
        job: String,
        /// Stage, if one was running.
        stage: Option<String>,
        /// Position of the block in its stage, from 0, if one was running.
        block: Option<usize>,
        /// Why.
        source: JobError,
    },
    /// Two jobs of a plan have the same id.
    #[error("two jobs are called `{id}`")]
    DuplicateJob {
        /// The id.
        id: String,
    },
    /// A job builds upon one that the plan does not have.
    #[error("job `{id}` builds upon `{upstream}`, which does not exist")]
    UnknownUpstream {
        /// The job.
        id: String,
        /// What it asks for.
        upstream: String,
    },
    /// Jobs build upon one another in a circle.
    #[error("jobs build upon one another in a circle: {}", jobs.join(" -> "))]
    Cycle {
        /// The circle; the first job stands again at the end.
        jobs: Vec<String>,
    },
    /// A value has no canonical form.
    #[error("{what} cannot be stored: {reason}")]
    NotCanonical {
        /// Which value.
        what: String,
        /// Why.
        reason: String,
    },
    /// A scheduler does not do what it was asked.
    #[error("{scheduler}: {reason}")]
    Scheduler {
        /// What people call it.
        scheduler: &'static str,
        /// What it says.
        reason: String,
    },
    /// What was asked of a cluster cannot be submitted so.
    #[error("{reason}")]
    Submission {
        /// Why, and what to do.
        reason: String,
    },
    /// The pool of threads could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system says.
        reason: String,
    },
    /// A file that should be a baseline is damaged.
    #[error("the baseline `{}` cannot be used: {reason}", path.display())]
    Baseline {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A manifest is not one.
    #[error("`{}` is not a manifest: {reason}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl RunnerError {
    /// Adds what was tried on which file to the system's answer.
    pub(crate) fn file(action: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { action, path, source }
    }
}

/// `, stage ..., block ...`, as far as known.
fn place(stage: Option<&str>, block: Option<usize>) -> String {
    let mut text = String::new();
    if let Some(stage) = stage {
        text.push_str(&format!(", stage `{stage}`"));
    }
    if let Some(block) = block {
        text.push_str(&format!(", block {block}"));
    }
    text
}
