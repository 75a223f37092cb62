//! The report's view of a pass whose jobs have run.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};
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

/// A job's result for other programs. Its single readings are made as they are written, so that they are in memory one at a
/// time.
pub struct Document<'r> {
    json: Value,
    readings: Option<Readings<'r>>,
}

/// The single readings of a job that has some.
struct Readings<'r>(&'r JobEntry);

/// Their name in a document.
const ROWS: &str = "rows";

impl Serialize for Readings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.output.rows().into_iter().flatten())
    }
}

impl Serialize for Document<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (Value::Object(entries), Some(readings)) = (&self.json, &self.readings) else {
            return self.json.serialize(serializer);
        };
        // In their place by the alphabet, as the others stand.
        let (before, after): (Vec<_>, Vec<_>) = entries.iter().partition(|(name, _)| name.as_str() < ROWS);
        let mut map = serializer.serialize_map(Some(entries.len() + 1))?;
        before.into_iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.serialize_entry(ROWS, readings)?;
        after.into_iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}

/// A job's result for other programs; `with_rows` keeps the single readings.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn document(job: &JobEntry, with_rows: bool) -> Result<Document<'_>, BatchError> {
    let json = job.output.document(with_rows).map_err(|error| BatchError::job(format!("{}: {error}", job.name)))?;
    let has_rows = with_rows && job.output.rows().is_some();
    Ok(Document { json, readings: has_rows.then_some(Readings(job)) })
}
