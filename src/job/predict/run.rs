//! The prediction as a job: the blocks of two propagations.

use crate::inference::gaussian_process::tested_range::Outside;
use crate::job::propagate::Discrepancy;
use crate::random::Distribution;
use crate::study::resolved::{Blocked, PosteriorReference, Upstream};
use crate::thermal::External;
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
    /// The discrepancy job whose laws are added.
    pub added: Option<Added>,
}

/// A discrepancy job, and to what its sensors add.
#[derive(Clone, Debug, PartialEq)]
pub struct Added {
    /// The job.
    pub from: Upstream,
    /// The job, for people.
    pub source: String,
    /// Why it does not run now, where it is another pass's.
    pub blocked: Option<Blocked>,
    /// Sensors, each with the positions of the quantities that it measures among those of the prediction.
    pub sensors: Vec<(String, Vec<usize>)>,
}

/// A discrepancy in one case of a prediction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Term {
    /// Environment.
    pub environment: String,
    /// Value of the design variable, SI; `None`: its nominal value.
    pub design_value: Option<f64>,
    /// Sensor behind it.
    pub sensor: String,
    /// The quantities that it is added to.
    pub quantities: Vec<String>,
    /// Law, in words.
    pub law: String,
    /// SI unit.
    pub unit: String,
    /// Mean at the posterior mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Inputs of the case outside what was tested: there the law is an extrapolation.
    pub outside: Vec<Outside>,
    /// Distance to the nearest phase behind the law, in its lengths; 0 without a Gaussian process.
    pub distance: f64,
}

/// What a prediction adds of a discrepancy job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Validated {
    /// The job.
    pub source: String,
    /// By case, then sensor.
    pub terms: Vec<Term>,
    /// The prediction with the posterior alone.
    pub without: propagate::Output,
}

/// A prediction, ready to run.
#[derive(Debug)]
pub struct Predict {
    pub(super) prior: Propagate,
    pub(super) posterior: Propagate,
    /// The posterior without what a discrepancy job adds to it, and what that is.
    pub(super) added: Option<(Propagate, Value, String, Vec<Term>, bool)>,
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
    /// What a discrepancy job adds to the posterior's; nothing without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validated: Option<Validated>,
}

impl Predict {
    /// The propagations, one after the other.
    fn propagations(&self) -> Vec<(&'static str, &Propagate)> {
        let mut propagations = vec![("prior", &self.prior)];
        if let Some((without, ..)) = &self.added {
            propagations.push(("calibrated", without));
        }
        propagations.push(("posterior", &self.posterior));
        propagations
    }

    /// The propagation that follows those whose results are known.
    fn at(&self, done: usize) -> Result<(&'static str, &Propagate), JobError> {
        let propagations = self.propagations();
        propagations.get(done).copied().ok_or_else(|| JobError::Failed("there is no further propagation".to_owned()))
    }

    /// A step of the propagation that follows those whose results are known.
    pub(super) fn step(&self, mut done: Vec<propagate::Output>, own: Step<Propagate>) -> Result<Step<Self>, JobError> {
        match own {
            Step::Blocks { stage, state: (), inputs } => {
                let (of, _) = self.at(done.len())?;
                Ok(Step::Blocks { stage: format!("{of} {stage}"), state: done, inputs })
            }
            Step::Done(result) => {
                done.push(*result);
                if done.len() < self.propagations().len() {
                    let begun = self.at(done.len())?.1.begin()?;
                    return self.step(done, begun);
                }
                let missing = || JobError::Failed("a result is not there".to_owned());
                let mut done = done.into_iter();
                let prior = done.next().ok_or_else(missing)?;
                let mut converged = true;
                let mut validated = None;
                if let Some((_, _, source, terms, has_converged)) = &self.added {
                    let without = done.next().ok_or_else(missing)?;
                    validated = Some(Validated { source: source.clone(), terms: terms.clone(), without });
                    converged = *has_converged;
                }
                let posterior = done.next().ok_or_else(missing)?;
                converged &= posterior.converged.unwrap_or(true);
                Ok(Step::Done(Box::new(Output { converged, posterior, prior, validated })))
            }
        }
    }

    /// The propagation with the priors that the calibration began with, and that with its posterior.
    pub fn new(prior: Propagate, posterior: Propagate) -> Self {
        Self { prior, posterior, added: None }
    }

    /// The same with the laws of a discrepancy job added: `without` is the propagation with the posterior alone, `identity`
    /// what of the job decides the result beside its key.
    pub fn with_added(
        self,
        without: Propagate,
        identity: Value,
        source: String,
        terms: Vec<Term>,
        converged: bool,
    ) -> Self {
        Self { added: Some((without, identity, source, terms, converged)), ..self }
    }
}

/// The document of `show --json`: that of the propagation with the posterior, and under `prior` the same with the priors.
pub fn view(output: &Output) -> Value {
    let mut document = propagate::view(&output.posterior);
    document["converged"] = json!(output.converged);
    document["prior"] = propagate::view(&output.prior);
    if let Some(validated) = &output.validated {
        document["discrepancy"] = json!({ "source": validated.source, "terms": validated.terms });
        document["without_discrepancy"] = propagate::view(&validated.without);
    }
    document
}

impl Job for Predict {
    /// The results of the propagations that have ended.
    type State = Vec<propagate::Output>;
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
        let mut identity = json!({ "prior": self.prior.identity(), "posterior": self.posterior.identity() });
        if let Some((_, added, ..)) = &self.added {
            identity["added"] = added.clone();
        }
        identity
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        self.step(Vec::new(), self.prior.begin()?)
    }

    fn block(
        &self,
        state: &Vec<propagate::Output>,
        input: BlockInput,
        parts: &dyn Parts,
    ) -> Result<BlockOutput, JobError> {
        self.at(state.len())?.1.block(&(), input, parts)
    }

    fn memory_bytes(&self) -> u64 {
        // One after the other.
        Job::memory_bytes(&self.prior).max(Job::memory_bytes(&self.posterior))
    }

    fn external(&self) -> Option<&External> {
        Job::external(&self.prior)
    }

    fn is_last(&self, state: &Vec<propagate::Output>) -> bool {
        state.len() + 1 == self.propagations().len()
    }

    fn reduce(&self, state: Vec<propagate::Output>, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let next = self.at(state.len())?.1.reduce((), blocks)?;
        self.step(state, next)
    }
}
