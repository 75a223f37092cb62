//! From a pass's resolved jobs to jobs that can run.

use std::sync::Arc;

use serde_json::Value;

use crate::diagnosis::Problem;
use crate::effect::candidates;
use crate::inference::likelihood::InputError;
use crate::inference::measurement::Measurement;
use crate::job::calibrate::{Calibrate, Inputs};
use crate::job::compare::{self, Compare, Tuned};
use crate::job::conventional::Conventional;
use crate::job::diagnose::{self, Diagnose};
use crate::job::propagate::Propagate;
use crate::job::{Job, JobError};
use crate::thermal::Model;

use super::model::Prior;
use super::resolve::sensor_places;
use super::resolved::{JobSpec, Pass};

/// A pass's job: ready, or why it does not run now.
pub enum Readiness {
    /// It can run.
    Ready(Arc<dyn Job>),
    /// It can run when another job of the pass has its result.
    After(Box<Deferred>),
    /// It does not run; the reason in a line.
    NotRun(String),
}

/// A comparison that waits for the calibration whose tuned state it shows.
pub struct Deferred {
    /// Name of the calibration in the pass.
    pub calibration: String,
    /// The comparison without it.
    comparison: Compare,
    spec: compare::Spec,
    model: Arc<Model>,
    measurements: Arc<Vec<Measurement>>,
    nominal: Vec<f64>,
}

impl Deferred {
    /// The job as far as it is known before.
    pub fn job(&self) -> &dyn Job {
        &self.comparison
    }

    /// Makes the job ready.
    ///
    /// # Errors
    /// A result of the calibration that holds no tuned state.
    pub fn prepare(&self, result: &Value) -> Result<Arc<dyn Job>, JobError> {
        let tuned = Tuned::from_result(&self.calibration, result)?;
        let (model, measurements) = (Arc::clone(&self.model), Arc::clone(&self.measurements));
        let comparison = Compare::new(self.spec.clone(), model, measurements, self.nominal.clone())?;
        Ok(Arc::new(comparison.with_tuned(tuned)))
    }
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
                    let nominal: Vec<f64> = pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
                    comparison(spec, &model, &measurements, nominal, pass)
                }
                JobSpec::Calibrate(spec) => {
                    let inputs = Inputs {
                        model: Arc::clone(&model),
                        priors: pass.priors.clone(),
                        measurements: Arc::clone(&measurements),
                        input_errors: input_errors(pass),
                    };
                    Calibrate::new(spec.clone(), inputs, pass.seed, &named.name)
                        .map(|job| Readiness::Ready(Arc::new(job)))
                }
                JobSpec::Diagnose(spec) => {
                    diagnosis(spec, &model, &measurements, pass, &named.name).map(|job| Readiness::Ready(Arc::new(job)))
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

fn diagnosis(
    spec: &diagnose::Spec,
    model: &Arc<Model>,
    measurements: &[Measurement],
    pass: &Pass,
    name: &str,
) -> Result<Diagnose, JobError> {
    let chosen: Vec<Measurement> = spec.data.iter().map(|&index| measurements[index].clone()).collect();
    let sensors = sensor_places(chosen.iter());
    let mut candidates = candidates(model, &pass.groups, &sensors, &pass.catalogue);
    candidates.retain(|candidate| spec.effects.contains(&candidate.effect));
    let problem = Problem {
        model: Arc::clone(model),
        priors: pass.priors.clone(),
        parameters: spec.parameters.clone(),
        measurements: chosen,
        input_errors: input_errors(pass),
        catalogue: Arc::clone(&pass.catalogue),
        candidates,
    };
    Diagnose::new(spec.clone(), problem, pass.seed, name)
}

fn comparison(
    spec: &compare::Spec,
    model: &Arc<Model>,
    measurements: &Arc<Vec<Measurement>>,
    nominal: Vec<f64>,
    pass: &Pass,
) -> Result<Readiness, JobError> {
    let job = Compare::new(spec.clone(), Arc::clone(model), Arc::clone(measurements), nominal.clone())?;
    let Some(name) = &spec.calibration else { return Ok(Readiness::Ready(Arc::new(job))) };
    let runs = pass.jobs.iter().any(|other| other.name == *name && matches!(other.spec, JobSpec::Calibrate(_)));
    if !runs {
        return Ok(Readiness::NotRun(format!("it shows the tuned state of `{name}`, which does not run")));
    }
    Ok(Readiness::After(Box::new(Deferred {
        calibration: name.clone(),
        comparison: job,
        spec: spec.clone(),
        model: Arc::clone(model),
        measurements: Arc::clone(measurements),
        nominal,
    })))
}

/// Own errors of the inputs; a prior from draws was refused when the pass was read.
pub(super) fn input_errors(pass: &Pass) -> Vec<InputError> {
    let bias = |prior: &Option<Prior>| match prior {
        Some(Prior::Distribution(distribution)) => Some(*distribution),
        _ => None,
    };
    pass.input_errors.iter().map(|error| InputError { sigma: error.sigma, bias: bias(&error.bias) }).collect()
}
