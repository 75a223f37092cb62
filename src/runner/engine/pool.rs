//! The threads of this machine: a pool for a run, and functions applied side by side.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use rayon::prelude::*;

use super::{Settings, StopFlag};
use crate::runner::error::RunnerError;
use crate::watch::{self, Stopped};

/// Stack of a thread of the pool, bytes: what the main thread has, so that a job behaves the same on both.
const STACK_BYTES: usize = 8 << 20;

/// A pool whose threads look at the flag.
///
/// # Errors
/// [`RunnerError::Threads`] if the system refuses.
pub(in crate::runner) fn pool(settings: &Settings, stop: &StopFlag) -> Result<rayon::ThreadPool, RunnerError> {
    let threads = settings.threads();
    let flag = stop.clone();
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK_BYTES)
        .start_handler(move |_| watch::lend(&flag))
        .build()
        .map_err(|error| RunnerError::Threads { threads, reason: error.to_string() })
}

/// Applies a pure function to items side by side; the results in the order of the items. `None` where the flag was raised.
///
/// # Errors
/// [`RunnerError::Threads`] if the pool cannot be started.
pub fn map<T: Sync, U: Send>(
    settings: &Settings,
    stop: &StopFlag,
    items: &[T],
    apply: impl Fn(&T) -> U + Sync,
) -> Result<Option<Vec<U>>, RunnerError> {
    let one = |item: &T| match catch_unwind(AssertUnwindSafe(|| apply(item))) {
        Ok(result) => Some(result),
        Err(payload) if Stopped::is(payload.as_ref()) => None,
        Err(payload) => resume_unwind(payload),
    };
    Ok(pool(settings, stop)?.install(|| items.par_iter().map(one).collect()))
}
