//! Prediction after calibration: a posterior carried to environments, beside the same with the priors that the
//! calibration began with.
//!
//! Both are propagations with the same points, so that their difference is not blurred by sampling: parameters that the
//! calibration did not infer keep their priors, and have the same values in both.

mod added;
mod form;
mod resolve;
mod run;

pub use run::{Added, Output, Predict, Prediction, Term, Validated, view};

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::propagate;
use crate::job::ready::{Readiness, Shared};
use crate::job::ready::{filled, unfilled};
use crate::study::blocked::blocked;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::resolved::PosteriorReference;
use crate::study::resolved::Upstream;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::PredictForm;

/// The kind `predict`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "predict";
    const ABOUT: &'static str = "Flight prediction.";
    const IS_AFTER_OTHERS: bool = true;
    type Form = PredictForm;
    type Spec = Prediction;
    type Output = Output;

    fn resolve(form: &PredictForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked)
    }

    fn document(output: &Output, _with_rows: bool) -> Result<Value, JobError> {
        Ok(view(output))
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        propagate::key_numbers(&output.posterior)
    }

    fn refuses_external(_spec: &Prediction, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn ready(spec: &Prediction, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let mut priors = shared.pass.priors.clone();
        for &(index, prior) in &spec.priors {
            priors[index] = prior;
        }
        let plain = shared.propagation(name, &spec.propagate, &priors);
        let (discrepancy, seed, named) = (spec.discrepancy.clone(), shared.pass.seed, name.to_owned());
        let make = move || plain()?.with_discrepancy(discrepancy.clone(), seed, &named);
        let (references, before, rest) =
            (vec![spec.posterior.clone()], spec.posterior_priors.clone(), rest(shared.pass, spec));
        let join = |first: Vec<PosteriorPrior>, rest: &[PosteriorPrior]| {
            first.into_iter().chain(rest.iter().cloned()).collect()
        };
        let others = unfilled(&rest);
        let prior = make()?.with_posterior_priors(join(unfilled(&before), &others));
        let with_posterior = || Ok::<_, JobError>(make()?.with_posterior_priors(join(unfilled(&references), &others)));
        let mut unprepared = Predict::new(prior, with_posterior()?);
        if let Some(added) = &spec.added {
            let identity = added::identity(added);
            unprepared = unprepared.with_added(with_posterior()?, identity, added.source.clone(), Vec::new(), true);
        }
        let draws = [references.clone(), before.clone(), rest.clone()];
        let mut from: Vec<Upstream> = draws.iter().flatten().filter_map(|reference| reference.from.clone()).collect();
        from.extend(spec.added.iter().map(|added| added.from.clone()));
        let (added, named, seed) = (spec.added.clone(), name.to_owned(), shared.pass.seed);
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let mut left = results.iter();
            let filled_draws = filled(&references, &mut left)?;
            let before = filled(&before, &mut left)?;
            let others = filled(&rest, &mut left)?;
            let prior = make()?.with_posterior_priors(join(before, &others));
            let with_posterior =
                || Ok::<_, JobError>(make()?.with_posterior_priors(join(filled_draws.clone(), &others)));
            let posterior = with_posterior()?;
            let Some(added) = &added else { return Ok(Arc::new(Predict::new(prior, posterior))) };
            let missing = || JobError::Failed("a result is not there".to_owned());
            let (calibration, law) = (results.first().ok_or_else(missing)?, left.next().ok_or_else(missing)?);
            let laws = added::laws(added, &posterior, &references[0], calibration, law)?;
            let posterior = match laws.posterior {
                Some(joint) => make()?.with_posterior_priors(join(vec![joint], &others)),
                None => posterior,
            };
            let posterior = posterior.with_adjustments(laws.adjustments, 0, seed, &named)?;
            let identity = added::identity(added);
            let predict = Predict::new(prior, posterior);
            let source = added.source.clone();
            Ok(Arc::new(predict.with_added(with_posterior()?, identity, source, laws.terms, laws.converged)))
        };
        if from.is_empty() {
            return prepare(&[]).map(Readiness::Ready);
        }
        Ok(Readiness::after(from, Arc::new(unprepared), Box::new(prepare)))
    }
}

impl study::job::Spec for Prediction {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        let calibration_blocked = match &self.posterior.from {
            Some(from) if from.file == pass.file => {
                blocked(pass, &from.job).map(|blocked_job| blocked_job.after(&self.posterior.draws.source))
            }
            _ => self.posterior.blocks(),
        };
        let others = rest(pass, self);
        let added = self.added.as_ref().and_then(|added| {
            let own = if added.from.file == pass.file { blocked(pass, &added.from.job) } else { None };
            let blocked_job = own.or_else(|| added.blocked.clone())?;
            let reason =
                format!("it adds the discrepancy of {}, which does not run: {}", added.source, blocked_job.reason);
            Some(Blocked { reason, ..blocked_job })
        });
        calibration_blocked
            .or(added)
            .or_else(|| others.iter().chain(&self.posterior_priors).find_map(PosteriorReference::blocks))
    }
}

/// Draws that stand in for priors of the parameters that a prediction's calibration did not infer.
fn rest(pass: &Pass, spec: &Prediction) -> Vec<PosteriorReference> {
    let mut rest = Vec::new();
    for reference in &pass.posterior_priors {
        let kept: Vec<usize> = (0..reference.draws.parameters.len())
            .filter(|&place| !spec.posterior.draws.parameters.contains(&reference.draws.parameters[place]))
            .collect();
        if !kept.is_empty() {
            rest.push(PosteriorReference { draws: reference.draws.with(&kept), ..reference.clone() });
        }
    }
    rest
}
