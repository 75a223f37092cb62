//! A pass and its jobs' results, put together for rendering.

use thiserror::Error;

use crate::job::kind;
use crate::measurement::Doubt;
use crate::runner::stored::Stored;
use crate::study::Pass;

use super::history::History;
use super::number::Shown;
use super::section::problem::prior_words;
use super::view::{FileHash, JobEntry, ParameterChange, PassReport, Siblings};

/// A result that does not have the form that this version writes.
#[derive(Debug, Error)]
#[error("the result of job `{job}` cannot be read: {source}")]
pub struct ResultError {
    /// The job.
    pub job: String,
    /// Why.
    pub source: serde_json::Error,
}

/// A finished job of the pass.
#[derive(Clone, Copy, Debug)]
pub struct FinishedJob<'r> {
    /// Name in the pass.
    pub name: &'r str,
    /// Kind.
    pub kind: &'r str,
    /// Key.
    pub key: &'r str,
    /// Result.
    pub result: &'r Stored,
}

/// What belongs to the report beside the pass and its results.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// Name of the study.
    pub study: String,
    /// Files that the results depend on, with their hashes.
    pub files: Vec<FileHash>,
    /// Version of the numeric engine.
    pub engine_version: String,
    /// The command that makes the report again.
    pub command: String,
    /// What the reader must know before believing.
    pub warnings: Vec<String>,
    /// The error of the passes before this one, and its own.
    pub history: Option<History>,
    /// The passes before and after.
    pub siblings: Option<Siblings>,
    /// SHA-256 of what the manifest says of where the report comes from.
    pub origin_sha256: Option<String>,
}

/// A parameter before (0) or after (1) a change, in words and in its own unit.
fn state(change: &crate::study::ParameterChange, which: usize) -> String {
    // One unit for both.
    let spreads = change.prior.iter().map(crate::random::Distribution::sd).filter(|sd| sd.is_finite());
    let shown =
        Shown::parameter_of(&change.unit, change.nominal.into_iter().map(f64::abs).chain(spreads).fold(0.0, f64::max));
    let prior = match (&change.draws, which) {
        (Some(source), 1) => format!("draws of {}", source.replace('`', "")),
        _ => prior_words(&change.prior[which], &shown),
    };
    format!("nominal {}, prior {prior}", shown.text(change.nominal[which]))
}

/// The report's view of a pass.
///
/// # Errors
/// A result that this version cannot read.
pub fn assemble<'p>(
    pass: &'p Pass,
    finished: &[FinishedJob<'_>],
    surroundings: Surroundings,
) -> Result<PassReport<'p>, ResultError> {
    let mut results = Vec::new();
    for job in finished {
        let Some(kind) = kind::find(job.kind) else { continue };
        let output = kind
            .output(&job.result.value, &job.result.arrays)
            .map_err(|source| ResultError { job: job.name.to_owned(), source })?;
        results.push(JobEntry {
            name: job.name.to_owned(),
            key: job.key.to_owned(),
            output,
            has_adopted: !pass.adopted.is_empty(),
        });
    }
    let names = pass.model.parameters.iter().map(|parameter| parameter.name.clone());
    Ok(PassReport {
        title: pass.title.clone(),
        pass_file: pass.file.clone(),
        study: surroundings.study,
        description: pass.description.clone(),
        reconstructed: pass.reconstructed.clone(),
        document: pass.document.as_deref().cloned(),
        siblings: surroundings.siblings,
        origin_sha256: surroundings.origin_sha256,
        closing: pass.closing.clone(),
        figures: pass.figures.clone(),
        model: &pass.model,
        groups: &pass.groups,
        priors: names.zip(pass.priors.iter().copied()).collect(),
        posterior_priors: (pass.posterior_priors.iter())
            .flat_map(|reference| {
                reference.draws.parameters.iter().map(|&index| (index, reference.draws.source.clone()))
            })
            .map(|(index, source)| (pass.model.parameters[index].name.clone(), source))
            .collect(),
        requirements: pass.requirements.clone(),
        statements: pass.statements.clone(),
        environments: pass.environments.clone(),
        measurements: &pass.measurements,
        tested: super::section::prediction::tested::of(pass),
        changes: pass
            .changes
            .iter()
            .map(|change| ParameterChange {
                what: change.name.clone(),
                before: state(change, 0),
                after: state(change, 1),
                because: change.because.clone(),
            })
            .collect(),
        adopted: pass.adopted.clone(),
        results,
        history: surroundings.history,
        files: surroundings.files,
        engine_version: surroundings.engine_version,
        command: surroundings.command,
        warnings: (surroundings.warnings.into_iter())
            .chain(pass.measurements.iter().flat_map(|measurement| measurement.doubts.iter().map(Doubt::in_words)))
            .collect(),
    })
}
