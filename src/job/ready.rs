//! From a pass's resolved jobs to jobs that can run.

use std::sync::Arc;

use serde_json::{Value, json};

use super::propagate::{self, Propagate};
use super::{JobError, Runnable, compare, kind, surrogate};
use crate::document::{Diagnostic, code};
use crate::measurement::Measurement;
use crate::random::Distribution;
use crate::study::Pass;
use crate::study::blocked::blocked;
use crate::study::job::{CALIBRATION, NamedJob};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolved::{Blocked, PosteriorReference, Upstream};
use crate::thermal::Model;

/// A pass's job: ready, or why it does not run now.
pub enum Readiness {
    /// It can run.
    Ready(Arc<dyn Runnable>),
    /// It can run when calibrations of the study have their results.
    After(Box<Deferred>),
    /// It does not run now; the reason in a line.
    NotRun(String),
    /// It cannot be made from its definition; what is wrong, at its place.
    Refused(Vec<Refusal>),
}

/// What is wrong with the definition of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Why it cannot be made.
    pub reason: String,
    /// The same at its place, with the name of the job.
    pub diagnostic: Diagnostic,
}

impl Refusal {
    /// In general: at the job's name.
    pub fn new(named: &NamedJob, reason: impl std::fmt::Display) -> Self {
        let reason = reason.to_string();
        let message = format!("job `{}` cannot be made: {reason}", named.name);
        Self { reason, diagnostic: Diagnostic::error(&code::JOB_REFUSED, &named.place, message) }
    }
}

impl From<Diagnostic> for Refusal {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { reason: diagnostic.message.clone(), diagnostic }
    }
}

/// Makes a job from the results that it waits for.
pub type Prepare = Box<dyn Fn(&[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> + Send + Sync>;

/// A job that waits for calibrations.
pub struct Deferred {
    /// The calibrations.
    pub from: Vec<Upstream>,
    /// The job as far as it is known before.
    known: Arc<dyn Runnable>,
    /// What decides the result beside the job's own identity and the calibrations.
    beside: Option<Value>,
    prepare: Prepare,
}

impl Deferred {
    /// The job as far as it is known before: kind and version.
    pub fn job(&self) -> &dyn Runnable {
        self.known.as_ref()
    }

    /// Everything that decides the result, beside the calibrations.
    pub fn identity(&self) -> Value {
        match &self.beside {
            None => self.known.identity(),
            Some(beside) => json!({ "job": self.known.identity(), "posterior_priors": beside }),
        }
    }

    /// Makes the job ready; `results` are those of [`Deferred::from`], in that order.
    ///
    /// # Errors
    /// Results that do not have what the job needs, draws that no density describes.
    pub fn prepare(&self, results: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        (self.prepare)(results)
    }
}

impl Readiness {
    /// A job that waits for the results of these calibrations; `known` is it as far as it is known before.
    pub fn after(from: Vec<Upstream>, known: Arc<dyn Runnable>, prepare: Prepare) -> Self {
        Self::After(Box::new(Deferred { from, known, beside: None, prepare }))
    }

    /// The same, but waiting for one more result first, which `take` puts to use.
    pub(super) fn behind(
        self,
        upstream: Upstream,
        take: impl Fn(&Value) -> Result<(), JobError> + Send + Sync + 'static,
    ) -> Self {
        let use_first = move |results: &[Arc<Value>]| -> Result<(), JobError> {
            take(results.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?)
        };
        match self {
            Self::Ready(job) => {
                let known = Arc::clone(&job);
                let prepare = move |results: &[Arc<Value>]| use_first(results).map(|()| Arc::clone(&job));
                Self::after(vec![upstream], known, Box::new(prepare))
            }
            Self::After(deferred) => {
                let Deferred { from, known, beside, prepare } = *deferred;
                let from = std::iter::once(upstream).chain(from).collect();
                let prepare: Prepare = Box::new(move |results| {
                    use_first(results)?;
                    prepare(results.get(1..).unwrap_or_default())
                });
                Self::After(Box::new(Deferred { from, known, beside, prepare }))
            }
            Self::NotRun(_) | Self::Refused(_) => self,
        }
    }

    /// The same with what decides the result beside the job's own identity and the calibrations.
    pub fn beside(mut self, beside: Value) -> Self {
        if let Self::After(deferred) = &mut self {
            deferred.beside = Some(beside);
        }
        self
    }
}

/// What the jobs of a pass share.
pub struct Shared<'p> {
    /// The pass.
    pub pass: &'p Pass,
    /// Its model.
    pub model: Arc<Model>,
    /// Its measurements.
    pub measurements: Arc<Vec<Measurement>>,
    /// Calibrations that cannot be made.
    pub refused: Vec<String>,
}

/// The jobs of a pass in order, each by its name. One that cannot be made from its definition (a network without a path
/// to a boundary, a nominal case that does not solve) keeps none of the others.
pub fn ready(pass: &Pass) -> Vec<(String, Readiness)> {
    let mut shared = Shared::new(pass, pass.refused.iter().map(|refused| refused.job.clone()).collect());
    // Comparisons show the delivered state where the tuned one cannot be had: so calibrations come first.
    let calibrations = pass.jobs.iter().filter(|named| named.spec.kind() == CALIBRATION);
    let mut made: Vec<(&str, Readiness)> =
        calibrations.map(|named| (named.name.as_str(), shared.readiness(named))).collect();
    let cannot = made.iter().filter(|(_, readiness)| matches!(readiness, Readiness::Refused(_)));
    shared.refused.extend(cannot.map(|(name, _)| (*name).to_owned()));
    let mut take = |named: &NamedJob| {
        let position = made.iter().position(|(name, _)| *name == named.name);
        position.map_or_else(|| shared.readiness(named), |position| made.swap_remove(position).1)
    };
    pass.jobs.iter().map(|named| (named.name.clone(), take(named))).collect()
}

/// A comparison of a pass without the tuned state; `None` for other jobs.
pub fn delivered(pass: &Pass, named: &NamedJob) -> Option<Readiness> {
    let spec: &compare::Spec = named.spec.get()?;
    let shared = Shared::new(pass, spec.calibration.iter().cloned().collect());
    shared.made(named).ok()
}

/// The draws, those of calibrations from their results; takes as many results as there are calibrations.
///
/// # Errors
/// A result that is not there or has no such draws.
pub fn filled(
    draws: &[PosteriorReference],
    results: &mut std::slice::Iter<'_, Arc<Value>>,
) -> Result<Vec<PosteriorPrior>, JobError> {
    let missing = || JobError::Failed("a result is not there".to_owned());
    let fill = |reference: &PosteriorReference| match reference.from {
        None => Ok(reference.draws.clone()),
        Some(_) => Ok(reference.draws.filled(results.next().ok_or_else(missing)?)?),
    };
    draws.iter().map(fill).collect()
}

/// The draws as far as they are known before.
pub fn unfilled(draws: &[PosteriorReference]) -> Vec<PosteriorPrior> {
    draws.iter().map(|reference| reference.draws.clone()).collect()
}

/// A job that waits for the calibrations behind these draws; ready at once where they are of none.
///
/// # Errors
/// What `prepare` gives.
pub fn after(
    draws: &[&[PosteriorReference]],
    known: Arc<dyn Runnable>,
    prepare: Prepare,
) -> Result<Readiness, JobError> {
    let from: Vec<Upstream> =
        draws.iter().flat_map(|list| list.iter()).filter_map(|reference| reference.from.clone()).collect();
    if from.is_empty() { prepare(&[]).map(Readiness::Ready) } else { Ok(Readiness::after(from, known, prepare)) }
}

impl<'p> Shared<'p> {
    fn new(pass: &'p Pass, refused: Vec<String>) -> Self {
        let (model, measurements) = (Arc::new(pass.model.clone()), Arc::new(pass.measurements.clone()));
        Self { pass, model, measurements, refused }
    }

    fn readiness(&self, named: &NamedJob) -> Readiness {
        let refusals = self.pass.refused.iter().filter(|refused| refused.job == named.name);
        let refusals: Vec<Refusal> = refusals.map(|refused| refused.diagnostic.clone().into()).collect();
        match blocked(self.pass, &named.name) {
            Some(_) if !refusals.is_empty() => Readiness::Refused(refusals),
            Some(Blocked { reason, is_wrong: false }) => Readiness::NotRun(reason),
            Some(Blocked { reason, is_wrong: true }) => Readiness::Refused(vec![Refusal::new(named, reason)]),
            None => self.made(named).unwrap_or_else(|error| Readiness::Refused(vec![Refusal::new(named, error)])),
        }
    }

    fn made(&self, named: &NamedJob) -> Result<Readiness, JobError> {
        let made = kind::find(named.spec.kind()).map(|kind| kind.ready(&named.spec, self, &named.name)).transpose()?;
        // What waits for something is blocked, with the reason.
        let made = made.flatten().unwrap_or_else(|| Readiness::NotRun(String::new()));
        Ok(if named.spec.get::<surrogate::Spec>().is_some() { made } else { surrogate::behind(self, made) })
    }

    /// A propagation with these priors, draws not yet in their place.
    pub fn propagation(
        &self,
        name: &str,
        spec: &propagate::Spec,
        priors: &[Distribution],
    ) -> impl Fn() -> Result<Propagate, JobError> + Send + Sync + use<> {
        let (spec, model, priors) = (spec.clone(), Arc::clone(&self.model), priors.to_vec());
        let (seed, name) = (self.pass.seed, name.to_owned());
        move || Propagate::new(spec.clone(), Arc::clone(&model), priors.clone(), seed, &name)
    }
}
