//! The kind `design`: what a study and the registry ask of it.

use std::sync::Arc;

use super::form::DesignForm;
use super::{Design, Output, Spec, resolve};
use crate::job::JobError;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};

/// The kind `design`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "design";
    const ABOUT: &'static str = "The experiment that teaches most.";
    type Form = DesignForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &DesignForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered).map(JobSpec::of)
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let (model, priors) = (Arc::clone(&shared.model), shared.pass.priors.clone());
        Ok(Readiness::Ready(Arc::new(Design::new(spec.clone(), model, priors, shared.pass.seed, name)?)))
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
