//! Which parameters matter: exact local derivatives, elementary effects, shares of the variance with intervals from
//! independent scrambles of Sobol points, and bounds of the total effects by mean squared derivatives.
//!
//! All methods take the priors as independent. A row of Saltelli's design of which any solve fails is left out whole, since its
//! differences are what the estimators are made of; how far that could move an index is part of the result.
//! Blocks hold sums, not values, so that memory does not grow with the number of points.

mod block;
mod evaluate;
mod form;
mod key_numbers;
mod one_at_a_time;
mod output;
mod resolve;
mod run;
mod sobol;
mod summary;
mod view;

pub use output::{
    Case, DerivativeBound, FailedSolve, Index, Local, Method, OfQuantity, Output, PairEffect, Parameter, Precision,
    Scatter, Sobol, Spec,
};
pub use run::Sensitivity;
pub use view::view;

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::SensitivityForm;

/// The kind `sensitivity`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "sensitivity";
    const ABOUT: &'static str = "Which parameters matter.";
    type Form = SensitivityForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &SensitivityForm, scope: &mut Scope, _entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, form, asked.offered).map(JobSpec::of)
    }

    fn document(output: &Output, _with_rows: bool) -> Result<Value, JobError> {
        Ok(view(output))
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        key_numbers::key_numbers(output)
    }

    fn refuses_external(spec: &Spec, derivatives: Derivatives) -> Option<String> {
        let is_by_slopes = spec.has(Method::Local) || spec.has(Method::Derivative);
        (is_by_slopes && derivatives == Derivatives::UsualSteps).then(|| {
            "the methods `local` and `derivative` need derivatives, which this model does not state: give it `steps` of differences \
             for all uncertain parameters, \"derivatives\": \"served\" where a server offers them, or take the methods `morris` and `sobol`"
                .to_owned()
        })
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let (model, priors) = (Arc::clone(&shared.model), shared.pass.priors.clone());
        Ok(Readiness::Ready(Arc::new(Sensitivity::new(spec.clone(), model, priors, shared.pass.seed, name)?)))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        study::blocked::by_draws(pass)
    }
}
