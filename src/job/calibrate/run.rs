//! The calibration as a job: what it is asked, and its stages.

use super::{Output, Spec};
use std::sync::Arc;

use serde_json::{Value, json};

use super::block::{Partial, State, Task};
use crate::inference::estimate::informed::Informed;
use crate::inference::estimate::point_estimate::{self, PointSettings};
use crate::inference::likelihood::{Definition, InputError, Likelihood};
use crate::inference::prior::joint_prior::Fit;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::measurement::Measurement;
use crate::measurement::prediction::Predictor;
use crate::random::{Distribution, StreamKey};
use crate::study::posterior_prior::PosteriorPrior;
use crate::thermal::{External, Model};

pub(super) const ESTIMATE: &str = "estimate";
pub(super) const SAMPLE: &str = "sample";
pub(super) const PREDICT: &str = "predict";

/// What a calibration is made of.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The model.
    pub model: Arc<Model>,
    /// Priors of its parameters, SI.
    pub priors: Vec<Distribution>,
    /// The pass's measurements.
    pub measurements: Arc<Vec<Measurement>>,
    /// Own errors of the inputs.
    pub input_errors: Vec<InputError>,
}

/// A calibration, ready to run.
#[derive(Debug)]
pub struct Calibrate {
    pub(super) spec: Spec,
    pub(super) inputs: Inputs,
    /// The likelihood with its priors, of which some may be the draws of a posterior.
    pub(super) target: Informed<Likelihood>,
    pub(super) posterior_priors: Vec<PosteriorPrior>,
    /// How well a density describes the draws of each posterior that is a prior.
    pub(super) fits: Vec<(String, Fit)>,
    pub(super) predictor: Predictor,
    pub(super) key: StreamKey,
    pub(super) name: String,
    pub(super) seed: u64,
}

impl Calibrate {
    /// Prepares the job; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// What no likelihood can be made of: no reading, no noise, nothing to infer, a network that does not compile.
    pub fn new(spec: Spec, inputs: Inputs, seed: u64, name: &str) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let measurements: Vec<&Measurement> = spec.data.iter().map(|&index| &inputs.measurements[index]).collect();
        let likelihood = Likelihood::new(&Definition {
            model: &inputs.model,
            priors: &inputs.priors,
            parameters: &spec.parameters,
            measurements: &measurements,
            input_errors: &inputs.input_errors,
        })
        .map_err(|e| failed(e.to_string()))?;
        let predictor = Predictor::new(&inputs.model, &[]).map_err(|e| failed(e.to_string()))?;
        let key = StreamKey::new(seed, name, "calibrate");
        let target = Informed::new(likelihood, Vec::new());
        let (posterior_priors, fits, name) = (Vec::new(), Vec::new(), name.to_owned());
        Ok(Self { spec, inputs, target, posterior_priors, fits, predictor, key, name, seed })
    }

    /// The same with posteriors in place of the priors of some parameters. Those without draws yet count for the job's
    /// identity alone. Of a posterior of more parameters than are chosen here, the others are averaged over.
    ///
    /// # Errors
    /// Draws that no density describes, with what deviates.
    pub fn with_posterior_priors(self, posterior_priors: Vec<PosteriorPrior>) -> Result<Self, JobError> {
        let (mut joint, mut fits) = (Vec::new(), Vec::new());
        for posterior_prior in posterior_priors.iter().filter(|posterior_prior| !posterior_prior.draws.is_empty()) {
            let density = posterior_prior
                .density(&self.target.target().unknowns().model, &self.inputs.priors)
                .map_err(|error| {
                    JobError::Failed(format!(
                        "the posterior of {} cannot be a prior here: {error}",
                        posterior_prior.source
                    ))
                })?;
            if let Some(density) = density {
                fits.push((posterior_prior.source.clone(), density.fit().clone()));
                joint.push(density);
            }
        }
        let target = Informed::new(self.target.target().clone(), joint);
        Ok(Self { target, posterior_priors, fits, ..self })
    }

    /// The likelihood with its priors.
    pub fn target(&self) -> &Informed<Likelihood> {
        &self.target
    }

    /// Own errors of the inputs.
    pub fn input_errors(&self) -> &[InputError] {
        &self.inputs.input_errors
    }

    /// Positions of its measurements in the pass's list.
    pub fn data(&self) -> &[usize] {
        &self.spec.data
    }

    pub(super) fn likelihood(&self) -> &Likelihood {
        self.target.target()
    }

    pub(super) fn measurements(&self) -> Vec<&Measurement> {
        self.spec.data.iter().map(|&index| &self.inputs.measurements[index]).collect()
    }

    pub(super) fn stream(&self, purpose: &str) -> StreamKey {
        StreamKey::new(self.seed, &self.name, purpose)
    }
}

impl Job for Calibrate {
    type State = State;
    type Input = Task;
    type Partial = Partial;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "calibrate"
    }

    fn algorithm_version(&self) -> u32 {
        9
    }

    fn identity(&self) -> Value {
        let data: Vec<Value> = self.measurements().iter().map(|measurement| measurement.identity()).collect();
        let mut identity = json!({
            "parameters": self.spec.parameters,
            "sampler": self.spec.sampler,
            "chains": self.spec.chains,
            "warmup": self.spec.warmup,
            "draws": self.spec.draws,
            "model": self.inputs.model.identity(),
            "priors": self.inputs.priors,
            "input_errors": self.inputs.input_errors,
            "data": data,
        });
        if let Some(acceptance) = self.spec.acceptance {
            identity["acceptance"] = json!(acceptance);
        }
        if self.evidence_error() > 0.0 {
            identity["evidence_error"] = json!(self.evidence_error());
        }
        if !self.posterior_priors.is_empty() {
            identity["posterior_priors"] = self.posterior_priors.iter().map(PosteriorPrior::identity).collect();
        }
        identity
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        if let Some(posterior_prior) =
            self.posterior_priors.iter().find(|posterior_prior| posterior_prior.draws.is_empty())
        {
            return Err(JobError::Failed(format!("the posterior of {} has no draws", posterior_prior.source)));
        }
        Ok(Step::Blocks { stage: ESTIMATE.to_owned(), state: State::Nothing, inputs: vec![Task::Estimate] })
    }

    fn block(&self, state: &State, task: Task, parts: &dyn Parts) -> Result<Partial, JobError> {
        match (state, task) {
            (State::Sample(estimate), task) => self.sample(estimate, task, parts),
            (_, Task::Predict { prior, draws }) => Ok(Partial::Predicted(self.predict(prior, &draws))),
            _ => {
                let key = self.stream("calibrate estimate");
                let settings = PointSettings::default();
                let best_fit = point_estimate::estimate(&self.target, &settings, &key, &[]);
                Ok(Partial::Estimate(Box::new(best_fit.map_err(|e| JobError::Failed(e.to_string()))?)))
            }
        }
    }

    fn memory_bytes(&self) -> u64 {
        // Draws with their likelihoods, as bytes, as chains, and as columns of parameters.
        let numbers = self.spec.chains.saturating_mul(self.spec.draws);
        let width = self.likelihood().unknowns().names.len() as u64 + 1;
        numbers.saturating_mul(3 * width).saturating_mul(size_of::<f64>() as u64)
    }

    fn external(&self) -> Option<&External> {
        self.predictor.network().external()
    }

    fn is_last(&self, state: &State) -> bool {
        matches!(state, State::Predict(_))
    }

    fn reduce(&self, state: State, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        match state {
            State::Nothing => match blocks.into_iter().next() {
                Some((_, Partial::Estimate(estimate))) => self.after_estimate(estimate),
                _ => Err(JobError::Failed("the most probable point is not there".to_owned())),
            },
            State::Sample(estimate) => self.after_samples(&estimate, blocks),
            State::Predict(output) => Ok(self.finish(output, blocks)),
        }
    }
}
