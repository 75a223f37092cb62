//! Exit statuses, in one place.

use std::process::ExitCode;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All is done.
    Done,
    /// Done, and a check failed, or a requirement where the status is to tell that.
    CheckFailed,
    /// The input is wrong, or what was asked for is not there.
    WrongInput,
    /// A job failed, or the system refused something that a job needs.
    JobFailed,
    /// Done, but a sampler did not converge.
    NotConverged,
    /// Interrupted; what was finished is kept.
    Interrupted,
    /// What one shard of a run says: its arguments are wrong.
    ShardUsage,
    /// What one shard of a run says: its definition is rejected, or a block of it fails; it would again.
    ShardRejected,
    /// What one shard of a run says: it may succeed another time.
    ShardTemporary,
}

impl Status {
    /// The number that the shell sees.
    pub const fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::CheckFailed => 1,
            Self::WrongInput => 2,
            Self::JobFailed => 3,
            Self::NotConverged => 4,
            Self::Interrupted => 130,
            // As in sysexits.h.
            Self::ShardUsage => 64,
            Self::ShardRejected => 65,
            Self::ShardTemporary => 75,
        }
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status.code())
    }
}

/// Why a command ends early: what to tell, and with which status.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// How the program ends.
    pub status: Status,
    /// What is stated on standard error.
    pub message: String,
    /// Whether the message is made of rendered diagnostics, which carry their own labels.
    pub is_rendered: bool,
}

impl Failure {
    /// The input is wrong.
    pub fn input(message: impl Into<String>) -> Self {
        Self { status: Status::WrongInput, message: message.into(), is_rendered: false }
    }

    /// The input is wrong: rendered diagnostics.
    pub fn rendered(message: impl Into<String>) -> Self {
        Self { is_rendered: true, ..Self::input(message) }
    }

    /// A job, or what follows from it, failed.
    pub fn job(message: impl Into<String>) -> Self {
        Self { status: Status::JobFailed, message: message.into(), is_rendered: false }
    }
}

impl From<crate::runner::RunnerError> for Failure {
    fn from(error: crate::runner::RunnerError) -> Self {
        use crate::runner::RunnerError as E;
        let status = match error {
            E::DuplicateJob { .. }
            | E::UnknownUpstream { .. }
            | E::Cycle { .. }
            | E::Submission { .. }
            | E::Manifest { .. }
            | E::Baseline { .. } => Status::WrongInput,
            _ => Status::JobFailed,
        };
        Self { status, message: error.to_string(), is_rendered: false }
    }
}

impl From<crate::batch::BatchError> for Failure {
    fn from(error: crate::batch::BatchError) -> Self {
        use crate::batch::BatchError as E;
        match error {
            E::Input(message) => Self::input(message),
            E::Rendered(message) => Self::rendered(message),
            E::Job(message) => Self::job(message),
            E::Runner(error) => error.into(),
        }
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::job(format!("cannot write: {error}"))
    }
}
