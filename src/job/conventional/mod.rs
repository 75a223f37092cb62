//! The conventional way: nominal and stacked worst-case analysis with margins by rule, and the size each leads to.
//!
//! The stack takes for each uncertain parameter the end of its prior that is worse for the requirement when tried
//! alone, the others nominal; priors without bounds are cut at 3 sigma. A size is the design value from which on, towards
//! the range's end, the rule passes: the smallest in a range that rises, the largest in one that falls. A heat-load
//! margin changes the heat loads of the case, nominal or stacked, up or down, whichever is worse.

mod form;
mod output;
mod resolve;
pub mod run;

pub use output::{Basis, Correlation, Output, Size, Spec, WorstEnd};
pub use run::Conventional;

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::filled;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::resolved::{PosteriorReference, Upstream};
use crate::study::{self, Pass};
use form::ConventionalForm;

/// The kind `conventional`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "conventional";
    const ABOUT: &'static str = "Stacked worst cases with margins by rule.";
    type Form = ConventionalForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &ConventionalForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked).map(JobSpec::of)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let number = |size: &Size| {
            let of = format!("{}, {} ({}, {})", size.requirement, size.environment, size.rule.name, size.basis.words());
            // The ends of draws scatter, by how much is not known.
            let scatters = output.from_draws && size.basis == Basis::StackedWorstCase;
            let value = size.size?;
            Some(if scatters {
                KeyNumber::new(of, "size", "SI", value, None)
            } else {
                KeyNumber::exact(of, "size", "SI", value)
            })
        };
        output.sizes.iter().filter_map(number).collect()
    }

    fn ready(spec: &Spec, shared: &Shared, _name: &str) -> Result<Readiness, JobError> {
        let mut known = shared.pass.priors.clone();
        for &(index, _, prior) in spec.knowledge.iter().flat_map(|knowledge| &knowledge.parameters) {
            known[index] = prior;
        }
        // Worst cases are stacked from the ends of the draws' intervals of three standard deviations; what an earlier pass
        // knew has none of them.
        let draws = if spec.knowledge.is_some() { Vec::new() } else { shared.pass.posterior_priors.clone() };
        let (made, model, file) = (spec.clone(), Arc::clone(&shared.model), shared.pass.file.clone());
        let make = move |draws: &[PosteriorPrior]| {
            let mut priors = known.clone();
            for posterior_prior in draws.iter().filter(|posterior_prior| !posterior_prior.draws.is_empty()) {
                for (place, &parameter) in posterior_prior.parameters.iter().enumerate() {
                    priors[parameter] = posterior_prior.interval(place);
                }
            }
            Ok::<_, JobError>(
                Conventional::new(made.clone(), Arc::clone(&model), priors)?.from_draws(!draws.is_empty()),
            )
        };
        let unprepared: Arc<dyn Runnable> = Arc::new(make(&[])?);
        // The job itself knows intervals only: whose they are must be stated.
        let beside: Value = draws.iter().map(|reference| reference.draws.identity()).collect();
        let has_draws = !draws.is_empty();
        let correlation = spec.correlation.clone();
        let mut from: Vec<Upstream> = draws.iter().filter_map(|reference| reference.from.clone()).collect();
        from.extend(correlation.iter().map(|job| Upstream { file: file.clone(), job: job.clone() }));
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let mut left = results.iter();
            let job = make(&filled(&draws, &mut left)?)?;
            let Some(name) = &correlation else { return Ok(Arc::new(job)) };
            let result = left.next().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
            Ok(Arc::new(job.with_correlation(Correlation::from_result(name, result)?)?))
        };
        if from.is_empty() {
            return Ok(Readiness::Ready(prepare(&[])?));
        }
        let readiness = Readiness::after(from, unprepared, Box::new(prepare));
        Ok(if has_draws { readiness.beside(beside) } else { readiness })
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        let correlation = self.correlation.as_ref().and_then(|name| {
            let runs = pass.jobs.iter().any(|job| job.name == *name && job.spec.resolved().is_some());
            (!runs).then(|| Blocked::waits(format!("it takes the values of `{name}`, which does not run")))
        });
        let draws = if self.knowledge.is_some() { &[][..] } else { &pass.posterior_priors };
        correlation.or_else(|| draws.iter().find_map(PosteriorReference::blocks))
    }
}
