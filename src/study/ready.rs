//! From a pass's resolved jobs to jobs that can run.

use std::sync::Arc;

use crate::job::compare::Compare;
use crate::job::conventional::Conventional;
use crate::job::propagate::Propagate;
use crate::job::{Job, JobError};

use super::resolved::{JobSpec, Pass};

/// A pass's job: ready, or why it does not run now.
pub enum Readiness {
    /// It can run.
    Ready(Arc<dyn Job>),
    /// It does not run; the reason in a line.
    NotRun(String),
}

/// The jobs of a pass in order, each by its name.
///
/// # Errors
/// The name of a job that cannot be made from its definition, with the reason: a network without a path to a boundary,
/// a nominal case that does not solve.
pub fn ready(pass: &Pass) -> Result<Vec<(String, Readiness)>, (String, JobError)> {
    let model = Arc::new(pass.model.clone());
    let measurements = Arc::new(pass.measurements.clone());
    pass.jobs
        .iter()
        .map(|named| {
            let job: Result<Readiness, JobError> = match &named.spec {
                JobSpec::Propagate(spec) => {
                    Propagate::new(spec.clone(), Arc::clone(&model), pass.priors.clone(), pass.seed, &named.name)
                        .map(|job| Readiness::Ready(Arc::new(job)))
                }
                JobSpec::Conventional(spec) => Conventional::new(spec.clone(), Arc::clone(&model), pass.priors.clone())
                    .map(|job| Readiness::Ready(Arc::new(job))),
                JobSpec::Compare(spec) => {
                    let nominal = pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
                    Compare::new(spec.clone(), Arc::clone(&model), Arc::clone(&measurements), nominal)
                        .map(|job| Readiness::Ready(Arc::new(job)))
                }
                JobSpec::Waiting { measurements, command, .. } => Ok(Readiness::NotRun(format!(
                    "the data of {} are not here; bring them with `{command}`",
                    measurements.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
                ))),
                JobSpec::NotYet { reason, .. } => Ok(Readiness::NotRun(reason.clone())),
            };
            job.map(|job| (named.name.clone(), job)).map_err(|error| (named.name.clone(), error))
        })
        .collect()
}
