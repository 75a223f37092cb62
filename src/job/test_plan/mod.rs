//! The plan of a test whose phases a design has chosen: what every sensor will read and how surely, how likely limits are left, how
//! long each phase takes to become steady, and the sheet on which the readings are written.
//!
//! Bands and probabilities are over the priors of all parameters, those that the design held at their nominal values among them: what
//! endangers hardware need not be what is to be learnt. A phase begins in the steady state of the one before and ends when the model's
//! sensors change more slowly than the criteria say; its inputs step. Phases keep the order of the design's choice, in which each adds
//! the most to those before it, so that a test that ends early has lost the least.
//!
//! One stage: `phases`, a phase a block.

mod data_sheet;
mod form;
mod output;
mod resolve;
mod run;

pub use data_sheet::{csv, measurement};
pub use output::{
    Instrument, Limited, Output, PlannedPhase, PlannedSensor, Predicted, Probability, SetPoint, Settling, Spec,
};
pub use run::{Chosen, TestPlan};

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::blocked::{self, blocked};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use form::TestPlanForm;

/// The kind `test-plan`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "test-plan";
    const ABOUT: &'static str = "The plan of a test that a design has chosen.";
    const IS_AFTER_OTHERS: bool = true;
    type Form = TestPlanForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &TestPlanForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked)
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let (spec, model, priors) = (spec.clone(), Arc::clone(&shared.model), shared.pass.priors.clone());
        let (from, seed, name) = (vec![spec.design.clone()], shared.pass.seed, name.to_owned());
        let make = move || TestPlan::new(spec.clone(), Arc::clone(&model), priors.clone(), seed, &name);
        let unprepared: Arc<dyn Runnable> = Arc::new(make()?);
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let result = results.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
            Ok(Arc::new(make()?.with_chosen(Chosen::from_result(result)?)))
        };
        Ok(Readiness::after(from, unprepared, Box::new(prepare)))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        let design = blocked(pass, &self.design.job).map(|design| {
            let reason = format!("it plans what `{}` chooses, which does not run: {}", self.design.job, design.reason);
            Blocked { reason, ..design }
        });
        design.or_else(|| blocked::by_draws(pass))
    }
}
