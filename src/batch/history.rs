//! The error of the passes of a study, from pass to pass.

use std::sync::Arc;

use super::executed::Executed;
use super::{BatchError, LoadedPass};
use crate::job::kind::{self, AnyOutput};
use crate::report::terminal::escaped;
use crate::report::{History, PassErrors};
use crate::study;

/// The error of passes of one study, each after its parents.
///
/// # Errors
/// A result that cannot be read.
pub fn history(passes: &[&LoadedPass], executed: &Executed) -> Result<History, BatchError> {
    let names: Vec<(&str, &[String])> =
        passes.iter().map(|pass| (pass.file.as_str(), pass.pass.parents.as_slice())).collect();
    let mut history = History::default();
    for position in study::history::order(&names) {
        let pass = passes[position];
        let judge = study::history::judged_by(&pass.pass);
        let output = |name: Option<&str>| -> Result<Option<Arc<dyn AnyOutput>>, BatchError> {
            let is_own = |at: usize| Some(executed.plan.nodes()[at].name.as_str()) == name;
            let found = executed.results(pass).find(|&(at, _)| is_own(at));
            let Some((at, job)) = found else { return Ok(None) };
            let kind = kind::find(executed.plan.nodes()[at].task.kind());
            let read = kind.map(|kind| kind.output(&job.stored.value, &job.stored.arrays)).transpose();
            read.map_err(|error| BatchError::job(format!("{}: {error}", escaped(&pass.shown))))
        };
        let (comparison, calibration) = judge.map_or((None, None), |judge| (Some(judge.comparison), judge.calibration));
        let outputs = (output(comparison)?, output(calibration)?);
        let diagnosis = output(judge.and_then(|judge| judge.diagnosis))?;
        let parent = pass.pass.parents.first();
        let parent = passes.iter().find(|other| Some(&other.file) == parent).map(|other| other.pass.as_ref());
        history.passes.push(PassErrors::new(
            &pass.pass,
            parent,
            comparison.zip(outputs.0.as_ref().and_then(|output| output.as_any().downcast_ref())),
            calibration.zip(outputs.1.as_ref().and_then(|output| output.as_any().downcast_ref())),
            diagnosis.as_ref().and_then(|output| output.as_any().downcast_ref()),
        ));
    }
    Ok(history)
}
