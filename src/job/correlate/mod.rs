//! Deterministic correlation with a test: parameters are changed within their ranges until measured minus predicted keeps
//! a profile of criteria, one parameter at a time or all together by least squares. What comes out are values without an
//! uncertainty; `conventional` puts margins on them again.

mod form;
mod output;
mod resolve;
mod run;
pub mod search;

pub use output::{Change, Correlated, Ended, Free, Method, Output, Spec};
pub use run::Correlate;

use std::sync::Arc;

use crate::job::JobError;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use form::CorrelateForm;

/// The kind `correlate`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "correlate";
    const ABOUT: &'static str = "Deterministic correlation with a test.";
    type Form = CorrelateForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &CorrelateForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let value = |own: &Correlated| KeyNumber::exact(own.name.clone(), "value", "SI", own.after);
        let rmse = KeyNumber::exact("readings fitted", "rmse", "K", output.after.rmse);
        output.parameters.iter().map(value).chain([rmse]).collect()
    }

    fn ready(spec: &Spec, shared: &Shared, _name: &str) -> Result<Readiness, JobError> {
        let job = Correlate::new(spec.clone(), Arc::clone(&shared.model), Arc::clone(&shared.measurements))?;
        Ok(Readiness::Ready(Arc::new(job)))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, _pass: &Pass) -> Option<Blocked> {
        None
    }
}
