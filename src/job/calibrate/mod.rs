//! Parameters from measurements: the most probable point from several starts, the posterior by chains or islands, the
//! evidence, and predictive checks.
//!
//! Stages: `estimate` (one block), `sample` (a chain, an island or the evidence a block), `predict` (draws of
//! posterior and prior). Chains start round the modes that the estimate found, spread by three halves of Laplace's
//! standard deviations.

pub mod block;
mod checks;
mod drawn;
mod form;
mod inference_data;
pub mod monte_carlo;
pub mod output;
pub mod predictive;
mod remedy;
mod resolve;
mod result;
mod run;
mod sampler;
mod sampling;
mod scores;
pub mod summary;
mod words;

pub use drawn::{Drawn, POSTERIOR, PRIOR, Replicates};
pub use inference_data::{LeftOut, Thinned};
pub use output::{
    Coverage, CrossValidation, Evidence, HeldOutScore, KeptDraws, MostProbable, Output, ParameterSummary, PhaseScore,
    PosteriorPriorOf, PredictiveRow, SensorPredictive, Spec, Spent, UsedData,
};
pub use remedy::{MANY_DRAWS, Remedy};
pub use run::{Calibrate, Inputs};
pub use sampler::{Sampler, is_long};
pub(in crate::job) use summary::Weighted;
pub(in crate::job) use words::objections;

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::job::ready::{after, filled, unfilled};
use crate::study::blocked::draws_among;
use crate::study::job::Inference;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::problem::input_errors;
use crate::study::resolve::scope::Scope;
use crate::study::resolved;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::CalibrateForm;

/// The kind `calibrate`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "calibrate";
    const ABOUT: &'static str = "Parameters from measurements.";
    type Form = CalibrateForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &CalibrateForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        monte_carlo::of_output(output)
    }

    fn refuses_external(spec: &Spec, derivatives: Derivatives) -> Option<String> {
        // Trajectories along any function of the place keep volumes, so that differences bias nothing where they are stated.
        (spec.sampler == Sampler::Nuts && derivatives == Derivatives::UsualSteps).then(|| {
            "the sampler `nuts` follows derivatives, which this model does not state: give it `steps` of differences for all uncertain \
             parameters, \"derivatives\": \"served\" where a server offers them, or take `adaptive-metropolis` or `smc`"
                .to_owned()
        })
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let draws = draws_among(shared.pass, &spec.parameters);
        let inputs = Inputs::of(shared);
        let unprepared = Calibrate::new(spec.clone(), inputs.clone(), shared.pass.seed, name)?;
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(unprepared)));
        }
        let unprepared = unprepared.with_posterior_priors(
            unfilled(&draws).into_iter().map(|posterior_prior| posterior_prior.with_no_draws()).collect(),
        )?;
        let (references, spec, seed, name) = (draws.clone(), spec.clone(), shared.pass.seed, name.to_owned());
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let job = Calibrate::new(spec.clone(), inputs.clone(), seed, &name)?;
            Ok(Arc::new(job.with_posterior_priors(filled(&references, &mut results.iter())?)?))
        };
        after(&[&draws], Arc::new(unprepared), Box::new(prepare))
    }
}

impl Inputs {
    /// Those of a pass.
    pub(in crate::job) fn of(shared: &Shared) -> Self {
        Self {
            model: Arc::clone(&shared.model),
            priors: shared.pass.priors.clone(),
            measurements: Arc::clone(&shared.measurements),
            input_errors: input_errors(shared.pass),
        }
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn inference(&self) -> Option<Inference<'_>> {
        Some(Inference { verb: "calibrates", data: &self.data, parameters: &self.parameters })
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        draws_among(pass, &self.parameters).iter().find_map(resolved::PosteriorReference::blocks)
    }
}
