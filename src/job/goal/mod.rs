//! Experimental goal setting (Stout 2015, step 3): how well the leading parameters must be known for all requirements to be met with
//! the required probability by the given design, which design value is within reach with what knowledge, and so which experiment
//! comes next.
//!
//! Better knowledge of a parameter is its prior times the likelihood of a measurement with a normal error. By itself it is tried at the
//! prior's mean, where it changes the spread alone; then over truths drawn from the prior, since a lucky truth is no merit of an experiment.

mod advice;
mod cell;
mod form;
pub mod knowledge;
mod output;
mod prior;
mod resolve;
mod result;
mod run;

pub use output::{Advice, Driving, Knowledge, Leading, Level, Met, Next, Output, Spec, Target, Truths};
pub use resolve::discrepancies;
pub use run::Goal;

use std::sync::Arc;

use crate::job::JobError;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::propagate::{Probability, of_probability};
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::GoalForm;

/// The kind `goal`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "goal";
    const ABOUT: &'static str = "Which parameter must be known how well.";
    type Form = GoalForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &GoalForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered).map(JobSpec::of)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let of_all = ("all requirements".to_owned(), &output.probability);
        let of_each = output
            .requirements
            .iter()
            .map(|met| (format!("{} ({})", met.requirement, met.environment), &met.probability));
        let number = |(of, probability): (String, &Probability)| {
            KeyNumber::new(of, "probability", "", probability.value, of_probability(probability))
        };
        std::iter::once(of_all).chain(of_each).map(number).collect()
    }

    fn refuses_external(_spec: &Spec, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let (model, priors) = (Arc::clone(&shared.model), shared.pass.priors.clone());
        Ok(Readiness::Ready(Arc::new(Goal::new(spec.clone(), model, priors, shared.pass.seed, name)?)))
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
