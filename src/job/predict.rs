//! Prediction after calibration: a posterior carried to environments, beside the same with the priors that the
//! calibration began with.
//!
//! Both are propagations with the same points, so that their difference is not blurred by sampling: parameters that the
//! calibration did not infer keep their priors, and have the same values in both.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::propagate::{self, Propagate};
use super::stored::{self, unreadable};
use super::{Job, JobError, Step};

/// Prefixes of the stages, by the propagation that they belong to.
const PRIOR: &str = "prior ";
const POSTERIOR: &str = "posterior ";

/// A prediction, ready to run.
#[derive(Debug)]
pub struct Predict {
    prior: Propagate,
    posterior: Propagate,
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

/// What the propagation with priors hands to the reduction of the other.
#[derive(Serialize, Deserialize)]
struct Carried(propagate::Output);

impl Predict {
    /// The propagation with the priors that the calibration began with, and that with its posterior.
    pub fn new(prior: Propagate, posterior: Propagate) -> Self {
        Self { prior, posterior }
    }

    /// The steps of the propagation with the posterior, which carry the other's result as a last block.
    fn with_posterior(&self, step: Step, carried: &Carried) -> Result<Step, JobError> {
        match step {
            Step::Blocks { stage, mut inputs } => {
                inputs.push(stored::to_bytes(carried)?);
                Ok(Step::Blocks { stage: format!("{POSTERIOR}{stage}"), inputs })
            }
            Step::Done(value) => {
                let posterior: propagate::Output =
                    serde_json::from_value(value).map_err(|error| JobError::Failed(error.to_string()))?;
                let converged = posterior.converged.unwrap_or(true);
                let output = Output { converged, posterior, prior: carried.0.clone() };
                stored::result(&output)
            }
        }
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

    fn begin(&self) -> Result<Step, JobError> {
        match self.prior.begin()? {
            Step::Blocks { stage, inputs } => Ok(Step::Blocks { stage: format!("{PRIOR}{stage}"), inputs }),
            done @ Step::Done(_) => Ok(done),
        }
    }

    fn block(&self, stage: &str, input: &[u8]) -> Result<Vec<u8>, JobError> {
        if let Some(own) = stage.strip_prefix(PRIOR) {
            return self.prior.block(own, input);
        }
        let own = stage.strip_prefix(POSTERIOR).ok_or_else(|| unreadable(stage, "there is no such stage"))?;
        if stored::from_bytes::<Carried>(input, stage).is_ok() {
            return Ok(Vec::new());
        }
        self.posterior.block(own, input)
    }

    fn memory_bytes(&self) -> u64 {
        // One after the other.
        self.prior.memory_bytes().max(self.posterior.memory_bytes())
    }

    fn is_last(&self, stage: &str) -> bool {
        stage.starts_with(POSTERIOR)
    }

    fn reduce(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        if let Some(own) = stage.strip_prefix(PRIOR) {
            return match self.prior.reduce(own, inputs, outputs)? {
                Step::Blocks { stage, inputs } => Ok(Step::Blocks { stage: format!("{PRIOR}{stage}"), inputs }),
                Step::Done(value) => {
                    let carried = serde_json::from_value(value).map_err(|error| unreadable(stage, error))?;
                    self.with_posterior(self.posterior.begin()?, &Carried(carried))
                }
            };
        }
        let own = stage.strip_prefix(POSTERIOR).ok_or_else(|| unreadable(stage, "there is no such stage"))?;
        let missing = || unreadable(stage, "the result with the priors is not there");
        let (last, inputs) = inputs.split_last().ok_or_else(missing)?;
        let (_, outputs) = outputs.split_last().ok_or_else(missing)?;
        let carried: Carried = stored::from_bytes(last, stage)?;
        let step = self.posterior.reduce(own, inputs, outputs)?;
        self.with_posterior(step, &carried)
    }
}
