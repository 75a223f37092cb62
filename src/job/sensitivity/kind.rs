//! The kind `sensitivity`: what a study and the registry ask of it.

use std::sync::Arc;

use serde_json::Value;

use super::form::SensitivityForm;
use super::{Output, Sensitivity, Spec, resolve, view};
use crate::job::JobError;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};

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
