//! The surrogate of a model that takes long to answer: a Gaussian process for each output through runs of the model, within the
//! priors and then where readings and requirements need them (the settings are the model's `surrogate`). The other jobs of
//! the pass wait for it, and ask it in the model's place.

mod form;
mod needs;
mod output;
mod run;

pub use output::{NeedState, Output, OutputError, ReadingError, Round, Trained};
pub use run::Train;

use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;

use crate::document::{Place, code};
use crate::inference::surrogate::Surrogate;
use crate::job::JobError;
use crate::job::calibrate::Inputs;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, Forms, JobSpec, NamedJob};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::Offered;
use crate::study::resolved::{Blocked, Upstream};
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::SurrogateForm;

/// The kind `surrogate`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

/// Settings: they stand in the model.
#[derive(Clone, Copy, Debug)]
pub struct Spec;

impl JobKind for Kind {
    const NAME: &'static str = "surrogate";
    const ABOUT: &'static str = "A Gaussian process in place of a model that takes long to answer.";
    type Form = SurrogateForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(_form: &SurrogateForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        if scope.resolved.surrogate.is_none() {
            let message = format!("`{}` is a surrogate, and the model asks for none", entry.name);
            let expected = "\"surrogate\": {\"runs\": ...} beside `command` or `umbridge` in the model";
            scope.error(&code::JOB_REFERENCE, &entry.name_place, message, expected);
            return None;
        }
        if asked.jobs.iter().any(|job| job.spec.kind() == Self::NAME)
            || asked.forms.of_kind(Self::NAME).first().is_some_and(|first| *first != entry.name)
        {
            let message = format!("`{}` is a second surrogate of one model", entry.name);
            scope.error(
                &code::JOB_REFERENCE,
                &entry.name_place,
                message,
                "one job `surrogate`, or none: it is implied",
            );
            return None;
        }
        Some(JobSpec::of(Spec))
    }

    fn refuses_external(_spec: &Spec, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn complete(jobs: &mut Vec<NamedJob>, forms: &Forms, offered: &Offered, _measured: Option<&Place>) {
        let Some(place) = offered.surrogate.filter(|_| forms.of_kind(Self::NAME).is_empty()) else { return };
        let mut name = Self::NAME.to_owned();
        while jobs.iter().any(|job| job.name == name) {
            name.push_str(" of the model");
        }
        // The others wait for it.
        jobs.insert(0, NamedJob { name, place: place.clone(), spec: JobSpec::of(Spec) });
    }

    fn document(output: &Output, with_rows: bool) -> Result<Value, JobError> {
        let mut document = serde_json::to_value(output).map_err(|error| JobError::Failed(error.to_string()))?;
        if let (false, Some(fields)) = (with_rows, document.as_object_mut()) {
            fields.remove("trained");
        }
        Ok(document)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let number = |own: &OutputError| {
            KeyNumber::searched(own.output.clone(), "cross-validated error", &own.unit, own.error, own.error)
        };
        output.outputs.iter().map(number).collect()
    }

    fn ready(_spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let pass = shared.pass;
        let none = || JobError::Failed("the model asks for no surrogate".to_owned());
        let surrogate = pass.surrogate.as_ref().map(Arc::clone).ok_or_else(none)?;
        let (requirements, environments) = (pass.requirements.clone(), pass.environments.clone());
        let inputs = Inputs::of(shared);
        Ok(Readiness::Ready(Arc::new(Train::new(surrogate, inputs, requirements, environments, pass.seed, name)?)))
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

/// A job that asks the surrogate of its pass, where there is one: it waits for that.
pub(super) fn behind(shared: &Shared, readiness: Readiness) -> Readiness {
    let pass = shared.pass;
    let asks = match &readiness {
        Readiness::Ready(job) => job.is_external(),
        Readiness::After(deferred) => deferred.job().is_external(),
        Readiness::NotRun(_) | Readiness::Refused(_) => false,
    };
    let Some(surrogate) = pass.surrogate.as_ref().filter(|_| asks) else { return readiness };
    let Some(job) = pass.jobs.iter().find(|job| job.spec.kind() == Kind::NAME) else { return readiness };
    if let Err(error) = Kind::ready(&Spec, shared, &job.name) {
        // The surrogate says so itself, at its place.
        return Readiness::NotRun(format!("the surrogate of its model cannot be made: {error}"));
    }
    let from = Upstream { file: pass.file.clone(), job: job.name.clone() };
    let answers = Arc::clone(&surrogate.answers);
    readiness.behind(from, move |result: &Value| {
        if answers.is_ready() {
            return Ok(());
        }
        let wrong = |reason: String| JobError::Failed(format!("the result of the surrogate cannot be used: {reason}"));
        let trained = result.get("trained").unwrap_or(&Value::Null);
        let trained = Trained::deserialize(trained).map_err(|error| wrong(error.to_string()))?;
        let made = Surrogate::new(trained.space, &trained.runs, &trained.emulations);
        answers.take(made.map_err(|error| wrong(error.to_string()))?);
        Ok(())
    })
}
