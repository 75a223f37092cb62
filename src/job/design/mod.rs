//! The experiment that teaches most: expected information gain about parameters over candidate phases, with nuisance
//! parameters integrated out, limits kept, several phases chosen one after the other, and sensors ranked.
//!
//! Stages: `predict` (a block a candidate: noise-free readings of all samples, limits), `information` (blocks of
//! replicates of a candidate; once more by another estimator where one cannot be trusted), `search N` (blocks of phases between the values of the grid, by Bayesian optimisation), then
//! `phase N` and `sensor N` for greedy choices. The readings of the samples are solved
//! once: those of a replicate are outer samples there and inner samples of the replicates before it. All candidates see
//! the same random numbers, so that their differences are known better than their values.

mod block;
mod choice;
mod form;
mod forward_model;
pub mod information;
mod output;
mod resolve;
mod run;
mod samples;
mod search;
mod summary;

pub use output::{
    Axis, Best, Candidate, DesignSensor, ErringInput, Estimator, Observed, Output, Partial, Phase, Pick, Redundant,
    Spec, UsedSensor, Varied, Violation,
};
pub use run::Design;

use std::sync::Arc;

use crate::job::JobError;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::statistics::monte_carlo::StandardError;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::DesignForm;
use samples::REPLICATES;

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

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        // What a search found lies elsewhere with another seed.
        let of_grid = output.candidates.iter().filter(|candidate| !candidate.is_found);
        let number = |candidate: &Candidate| {
            let conditions: Vec<String> =
                candidate.conditions.iter().map(|(input, value)| format!("{input} = {value}")).collect();
            let error = StandardError::new(candidate.se?, Some(REPLICATES as f64 - 1.0));
            let value = candidate.information_nats?;
            Some(KeyNumber::new(conditions.join(", "), "information", "nat", value, error))
        };
        of_grid.filter_map(number).collect()
    }

    fn refuses_external(spec: &Spec, derivatives: Derivatives) -> Option<String> {
        let is_by_slopes = matches!(spec.estimator, Estimator::Laplace | Estimator::Linear);
        (is_by_slopes && derivatives == Derivatives::UsualSteps).then(|| {
            format!(
                "the estimator `{}` needs derivatives, which this model does not state: give it `steps` of differences for all \
                 uncertain parameters, \"derivatives\": \"served\" where a server offers them, or take the estimator `nested`",
                spec.estimator.name()
            )
        })
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
