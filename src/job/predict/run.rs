//! The prediction as a job: the blocks of two propagations.

use crate::job::propagate::Discrepancy;
use crate::random::Distribution;
use crate::study::resolved::PosteriorReference;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::job::propagate::{self, BlockInput, BlockOutput, Propagate};
use crate::job::{Done, Job, JobError, Parts, Step};

/// Settings with everything looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// What is asked.
    pub propagate: propagate::Spec,
    /// The posterior.
    pub posterior: PosteriorReference,
    /// The priors that the calibration began with: position in the model's list, prior (SI).
    pub priors: Vec<(usize, Distribution)>,
    /// Draws that stood in for some of them.
    pub posterior_priors: Vec<PosteriorReference>,
    /// Errors of the model that are added to quantities.
    pub discrepancy: Vec<Discrepancy>,
}

/// A prediction, ready to run.
#[derive(Debug)]
pub struct Predict {
    pub(super) prior: Propagate,
    pub(super) posterior: Propagate,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Whether the chains behind the posterior converged.
    pub converged: bool,
    /// With the posterior.
    pub posterior: propagate::Output,
    /// With the priors that the calibration began with.
    pub prior: propagate::Output,
}

impl Predict {
    /// A step of the propagation with the posterior, where the result with the priors is known, else of the one with them.
    pub(super) fn step(&self, prior: Option<propagate::Output>, own: Step<Propagate>) -> Result<Step<Self>, JobError> {
        match (own, prior) {
            (Step::Blocks { stage, state: (), inputs }, prior) => {
                let of = if prior.is_some() { "posterior" } else { "prior" };
                Ok(Step::Blocks { stage: format!("{of} {stage}"), state: prior, inputs })
            }
            (Step::Done(prior), None) => self.step(Some(*prior), self.posterior.begin()?),
            (Step::Done(posterior), Some(prior)) => {
                let converged = posterior.converged.unwrap_or(true);
                Ok(Step::Done(Box::new(Output { converged, posterior: *posterior, prior })))
            }
        }
    }

    /// The propagation with the priors that the calibration began with, and that with its posterior.
    pub fn new(prior: Propagate, posterior: Propagate) -> Self {
        Self { prior, posterior }
    }
}

/// The document of `show --json`: that of the propagation with the posterior, and under `prior` the same with the priors.
pub fn view(output: &Output) -> Value {
    let mut document = propagate::view(&output.posterior);
    document["converged"] = json!(output.converged);
    document["prior"] = propagate::view(&output.prior);
    document
}

impl Job for Predict {
    /// The result with the priors, once it is known.
    type State = Option<propagate::Output>;
    type Input = BlockInput;
    type Partial = BlockOutput;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "predict"
    }

    fn algorithm_version(&self) -> u32 {
        // A change of the propagation changes this result too.
        100 * self.posterior.algorithm_version() + 1
    }

    fn identity(&self) -> Value {
        json!({ "prior": self.prior.identity(), "posterior": self.posterior.identity() })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        self.step(None, self.prior.begin()?)
    }

    fn block(
        &self,
        state: &Option<propagate::Output>,
        input: BlockInput,
        parts: &dyn Parts,
    ) -> Result<BlockOutput, JobError> {
        if state.is_some() { &self.posterior } else { &self.prior }.block(&(), input, parts)
    }

    fn memory_bytes(&self) -> u64 {
        // One after the other.
        Job::memory_bytes(&self.prior).max(Job::memory_bytes(&self.posterior))
    }

    fn is_last(&self, state: &Option<propagate::Output>) -> bool {
        state.is_some()
    }

    fn reduce(&self, state: Option<propagate::Output>, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let propagation = if state.is_some() { &self.posterior } else { &self.prior };
        self.step(state, propagation.reduce((), blocks)?)
    }
}
