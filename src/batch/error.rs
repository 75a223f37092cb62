//! Errors of batches.

use crate::runner::RunnerError;

/// Why a batch of passes cannot be loaded, planned, run or archived.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The input is wrong: the message says what, at its place.
    #[error("{0}")]
    Input(String),
    /// The input is wrong: rendered diagnostics.
    #[error("{0}")]
    Rendered(String),
    /// What came of a job cannot be read or written.
    #[error("{0}")]
    Job(String),
    /// The runner refuses the jobs, or the system the runner.
    #[error(transparent)]
    Runner(#[from] RunnerError),
}

impl BatchError {
    /// The input is wrong.
    pub fn input(message: impl Into<String>) -> Self {
        Self::Input(message.into())
    }

    /// What came of a job cannot be read or written.
    pub fn job(message: impl Into<String>) -> Self {
        Self::Job(message.into())
    }
}
