//! Propagation: samples of the priors through the model, to distributions of quantities and to the probability that
//! requirements are met, along a design variable where one is swept.
//!
//! Every case (environment and design value) uses the same samples, so that differences between cases are not blurred by
//! sampling. A sample is one row of a point set, each uncertain parameter one quantile of it.
//!
//! Parameters with a posterior as prior take one of its draws together: the coordinate of the first of them picks the
//! draw, so that a stratified point set uses all draws equally often. The draws are not smoothed: a kernel would widen
//! the posterior, and blur its bounds and bends, to hide a coarseness that the parameters propagated beside it blur
//! anyway; what the number of draws leaves open stands in the intervals instead (`statistics::clusters`).

pub mod block;
mod form;
mod key_numbers;
mod main_effects;
pub mod output;
pub mod reached;
mod resolve;
mod run;
mod so_far;
mod summary;
pub mod view;

pub use block::{BlockInput, BlockOutput};
pub use form::{PropagateForm, SamplingForm};
pub use key_numbers::{key_numbers, of_probability};
pub use output::{
    AddedDiscrepancy, Adjustment, Case, CaseInputs, Conditional, Discrepancy, Distributed, FailedSample, Joint,
    MainEffect, Met, Output, Probability, Quantile, Reached, Sampling, Spec,
};
pub use resolve::resolve;
pub use run::Propagate;
pub use view::view;

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::job::ready::{after, filled, unfilled};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::resolved::PosteriorReference;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;

/// The kind `propagate`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "propagate";
    const ABOUT: &'static str = "Propagation of the parameters' uncertainty.";
    type Form = PropagateForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &PropagateForm, scope: &mut Scope, _entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve(scope, form, asked.offered).map(JobSpec::of)
    }

    fn document(output: &Output, _with_rows: bool) -> Result<Value, JobError> {
        Ok(view(output))
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        key_numbers(output)
    }

    fn refuses_external(_spec: &Spec, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let draws = shared.pass.posterior_priors.clone();
        let make = shared.propagation(name, spec, &shared.pass.priors);
        let unprepared = make()?.with_posterior_priors(unfilled(&draws));
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(unprepared)));
        }
        let references = draws.clone();
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            Ok(Arc::new(make()?.with_posterior_priors(filled(&references, &mut results.iter())?)))
        };
        after(&[&draws], Arc::new(unprepared), Box::new(prepare))
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
