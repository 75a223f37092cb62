//! The conventional way: nominal and stacked worst-case analysis with margins by rule, and the size each leads to.
//!
//! The stack takes for each uncertain parameter the end of its prior that is worse for the requirement when tried
//! alone, the others nominal; priors without bounds are cut at 3 sigma. A size is the design value from which on, towards
//! the range's end, the rule passes: the smallest in a range that rises, the largest in one that falls. A heat-load
//! margin changes the heat loads of the case, nominal or stacked, up or down, whichever is worse.

mod form;
mod output;
mod resolve;
mod run;

pub use output::{Basis, Output, Size, Spec, WorstEnd};
pub use run::Conventional;

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::job::ready::{after, filled};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::resolved::PosteriorReference;
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
        resolve::resolve(scope, entry, form, asked.offered).map(JobSpec::of)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let number = |size: &Size| {
            let of = format!("{}, {} ({}, {})", size.requirement, size.environment, size.rule.name, size.basis.words());
            Some(KeyNumber::new(of, "size", "SI", size.size?, None))
        };
        output.sizes.iter().filter_map(number).collect()
    }

    fn ready(spec: &Spec, shared: &Shared, _name: &str) -> Result<Readiness, JobError> {
        // Worst cases are stacked from the ends of the draws' intervals of three standard deviations.
        let draws = shared.pass.posterior_priors.clone();
        let (spec, model, priors) = (spec.clone(), Arc::clone(&shared.model), shared.pass.priors.clone());
        let make = move |draws: &[PosteriorPrior]| {
            let mut priors = priors.clone();
            for posterior_prior in draws.iter().filter(|posterior_prior| !posterior_prior.draws.is_empty()) {
                for (place, &parameter) in posterior_prior.parameters.iter().enumerate() {
                    priors[parameter] = posterior_prior.interval(place);
                }
            }
            Conventional::new(spec.clone(), Arc::clone(&model), priors)
        };
        let unprepared: Arc<dyn Runnable> = Arc::new(make(&[])?);
        // The job itself knows intervals only: whose they are must be stated.
        let beside: Value = draws.iter().map(|reference| reference.draws.identity()).collect();
        let references = draws.clone();
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            Ok(Arc::new(make(&filled(&references, &mut results.iter())?)?))
        };
        Ok(after(&[&draws], unprepared, Box::new(prepare))?.beside(beside))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        pass.posterior_priors.iter().find_map(PosteriorReference::blocks)
    }
}
