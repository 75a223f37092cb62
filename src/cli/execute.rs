//! Running the jobs of passes with progress, event log and interruption: what every computing verb does.

use std::path::PathBuf;

use super::Context;
use super::options::{CacheOption, RunOptions};
use super::output::tell;
use super::status::{Failure, Status};
use crate::batch::{self, Executed, Loaded, LoadedPass, Prepared};
use crate::document::Diagnostic;
use crate::runner::{Cache, EventLog, Listener, Progress};
use crate::study::Pass;

impl Status {
    /// How the program ends after this run.
    pub fn of(executed: &Executed) -> Self {
        if executed.is_interrupted {
            Self::Interrupted
        } else if executed.summary.failures() > 0 {
            Self::JobFailed
        } else if executed.passes.iter().any(|pass| !pass.refused.is_empty()) {
            Self::WrongInput
        } else if executed.not_converged().next().is_some() {
            Self::NotConverged
        } else {
            Self::Done
        }
    }

    /// As [`Status::of`], where the wanted jobs are all that the command is for: that none could run, because data are
    /// not here, is then no success.
    pub fn of_wanted(executed: &Executed) -> Self {
        match Self::of(executed) {
            Self::Done if executed.passes.iter().all(|pass| pass.jobs.is_empty() && !pass.not_run.is_empty()) => {
                Self::WrongInput
            }
            status => status,
        }
    }
}

/// Loads, plans and runs the wanted jobs of the passes under these paths; `wanted` sees kind and name.
///
/// # Errors
/// Wrong input, or a refusal of the system. What goes wrong with a job is in the summary.
pub fn execute(
    paths: &[PathBuf],
    options: &RunOptions,
    context: &Context,
    wanted: impl Fn(&str, &str) -> bool,
) -> Result<Executed, Failure> {
    let loaded = batch::load(paths, &context.reading)?;
    execute_loaded(loaded, Loaded::default(), options, context, |_, kind, name| wanted(kind, name))
}

/// As [`execute`], for passes that are loaded; of `parents` the jobs run by which passes are judged.
///
/// # Errors
/// As [`execute`].
pub fn execute_loaded(
    loaded: Loaded,
    parents: Loaded,
    options: &RunOptions,
    context: &Context,
    wanted: impl Fn(&Pass, &str, &str) -> bool,
) -> Result<Executed, Failure> {
    run(prepare(loaded, parents, context, wanted)?, options, context)
}

/// As [`batch::prepare`]; what people should know of the files is stated.
///
/// # Errors
/// As there.
pub fn prepare(
    loaded: Loaded,
    parents: Loaded,
    context: &Context,
    wanted: impl Fn(&Pass, &str, &str) -> bool,
) -> Result<Prepared, Failure> {
    tell_notes(&loaded.notes);
    let prepared = batch::prepare(loaded, parents, wanted)?;
    tell_refused(prepared.passes(), context.coloured);
    Ok(prepared)
}

/// Runs what is wanted and not in the cache, with progress on standard error and an event log.
///
/// # Errors
/// A job that needs more memory than the machine has; a refusal of the system. What goes wrong with a job is in the
/// summary.
pub fn run(prepared: Prepared, options: &RunOptions, context: &Context) -> Result<Executed, Failure> {
    let run = |prepared: Prepared, cache: &Cache, listener: &dyn Listener| {
        let settings = options.settings();
        prepared.memory_notes(cache, settings.force).iter().for_each(|note| tell(note));
        prepared.run(settings, cache, &context.interrupts, listener)
    };
    Ok(run_listened(prepared, &options.cache, run)?)
}

/// Has `run` run what is prepared with this cache and a listener, which shows progress on standard error and keeps an event
/// log.
///
/// # Errors
/// Those of `run`.
pub fn run_listened<E>(
    prepared: Prepared,
    cache: &CacheOption,
    run: impl FnOnce(Prepared, &Cache, &dyn Listener) -> Result<Executed, E>,
) -> Result<Executed, E> {
    if let Some(note) = cache.shared(prepared.passes()) {
        tell(&note);
    }
    let progress = Progress::on_standard_error();
    let log = EventLog::create(&cache.events(prepared.passes()));
    let mut listeners: Vec<&dyn Listener> = vec![&progress];
    match &log {
        Ok(log) => listeners.push(log),
        Err(error) => tell(&format!("warning: no event log: {error}")),
    }
    let cache = cache.cache(prepared.passes());
    run(prepared, &cache, &listeners)
}

/// Tells what people should know of the files, each thing once.
pub fn tell_notes(notes: &[String]) {
    for (position, note) in notes.iter().enumerate() {
        if !notes[..position].contains(note) {
            tell(note);
        }
    }
}

/// Tells what is wrong with the jobs that cannot be made, each thing once.
pub fn tell_refused(passes: &[LoadedPass], coloured: bool) {
    let mut said: Vec<&Diagnostic> = Vec::new();
    for diagnostic in passes.iter().flat_map(|pass| &pass.refused).flat_map(|refused| &refused.diagnostics) {
        if !said.contains(&diagnostic) {
            tell(&diagnostic.render(coloured));
            said.push(diagnostic);
        }
    }
}
