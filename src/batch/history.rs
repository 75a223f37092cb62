//! The error of the passes of a study, from pass to pass.

use std::sync::Arc;

use serde_json::Value;

use super::executed::Executed;
use super::{BatchError, LoadedPass};
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
        let result = |name: Option<&str>| -> Option<(String, Arc<Value>)> {
            let is_own = |at: usize| Some(executed.plan.nodes()[at].name.as_str()) == name;
            let (at, job) = executed.results(pass).find(|&(at, _)| is_own(at))?;
            Some((executed.plan.nodes()[at].name.clone(), Arc::clone(&job.stored.value)))
        };
        let comparison = result(judge.map(|judge| judge.comparison));
        let calibration = result(judge.and_then(|judge| judge.calibration));
        let parent = pass.pass.parents.first();
        let parent = passes.iter().find(|other| Some(&other.file) == parent).map(|other| other.pass.as_ref());
        let errors = PassErrors::new(
            &pass.pass,
            parent,
            comparison.as_ref().map(|(name, value)| (name.as_str(), value.as_ref())),
            calibration.as_ref().map(|(name, value)| (name.as_str(), value.as_ref())),
        );
        history.passes.push(errors.map_err(|error| BatchError::job(format!("{}: {error}", escaped(&pass.shown))))?);
    }
    Ok(history)
}
