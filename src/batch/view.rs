//! The report's view of a pass whose jobs have run.

use serde_json::Value;

use super::archive::study_name;
use super::executed::Executed;
use super::graph::in_study;
use super::{BatchError, LoadedPass};
use crate::report::assemble::{FinishedJob, Surroundings, assemble};
use crate::report::terminal::escaped;
use crate::report::{JobEntry, PassReport};
use crate::runner::{Outcome, RunnerError};

/// The report's view of a pass with its finished jobs, without what only an archived report needs.
///
/// # Errors
/// A result that cannot be read.
pub fn view<'p>(pass: &'p LoadedPass, executed: &Executed) -> Result<PassReport<'p>, BatchError> {
    view_in(pass, executed, Surroundings::default())
}

/// Which of a pass's jobs failed or were skipped, each with the reason.
fn failures(pass: &LoadedPass, executed: &Executed) -> impl Iterator<Item = String> {
    pass.jobs.iter().filter_map(|id| {
        let name = &executed.plan.nodes()[executed.plan.find(id)?].name;
        match executed.summary.outcomes.get(id)? {
            Outcome::Failed(error) => {
                let reason = match error.as_ref() {
                    RunnerError::Job { source, .. } => source.to_string(),
                    RunnerError::NotCanonical { reason, .. } => reason.clone(),
                    // Where the two lie was printed; a report names no place of this machine.
                    RunnerError::Nondeterministic { .. } => "computed twice, it gave two results".to_owned(),
                    other => other.to_string(),
                };
                Some(format!("Job {name} has no result: {reason}."))
            }
            Outcome::Skipped { upstream } => {
                Some(format!("Job {name} has no result: it builds on {}, which has none.", in_study(upstream)))
            }
            Outcome::Finished(_) | Outcome::Interrupted => None,
        }
    })
}

pub(super) fn view_in<'p>(
    pass: &'p LoadedPass,
    executed: &Executed,
    surroundings: Surroundings,
) -> Result<PassReport<'p>, BatchError> {
    let jobs: Vec<FinishedJob<'_>> = executed
        .results(pass)
        .map(|(position, job)| {
            let node = &executed.plan.nodes()[position];
            FinishedJob { name: &node.name, kind: node.task.kind(), key: job.key.as_str(), result: &job.stored }
        })
        .collect();
    let warnings = pass.not_run.iter().cloned().chain(failures(pass, executed)).collect();
    let surroundings = Surroundings { study: study_name(&pass.study), warnings, ..surroundings };
    assemble(&pass.pass, &jobs, surroundings)
        .map_err(|error| BatchError::job(format!("{}: {error}", escaped(&pass.shown))))
}

/// Takes the single readings out of results; a terminal shows their statistics.
pub fn without_rows(report: &mut PassReport<'_>) {
    for job in &mut report.results {
        if let Some(output) = job.output.without_rows() {
            job.output = output;
        }
    }
}

/// A job's result for other programs; `with_rows` keeps the single readings.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn document(job: &JobEntry, with_rows: bool) -> Result<Value, BatchError> {
    job.output.document(with_rows).map_err(|error| BatchError::job(format!("{}: {error}", job.name)))
}
