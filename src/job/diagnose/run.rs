//! The diagnosis as a job: what it is asked, what its stages know, and its blocks.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::diagnosis::output::PriorOfDraws;
use crate::diagnosis::{Diagnosis, FitRequest, Output, Problem, Refit, Settings, State, Unfitted};
use crate::job::stored::unreadable;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::random::StreamKey;
use crate::study::posterior_prior::PosteriorPrior;
use crate::watch;

pub(super) const SCREEN: &str = "screen";
pub(super) const REFIT: &str = "refit";
pub(super) const EXTEND: &str = "extend";
pub(super) const CONCLUDE: &str = "conclude";
/// Sets of a block; of transients, whose fits differ in length and take long, one is a block.
pub(super) const BLOCK: usize = 4;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Positions of the measurements.
    pub data: Vec<usize>,
    /// Positions of the parameters that are inferred.
    pub parameters: Vec<usize>,
    /// Names of the effects that are considered.
    pub effects: Vec<String>,
    /// Settings of the diagnosis.
    pub settings: Settings,
}

/// A diagnosis, ready to run.
#[derive(Debug)]
pub struct Diagnose {
    pub(super) spec: Spec,
    pub(super) diagnosis: Diagnosis,
    pub(super) posterior_priors: Vec<PosteriorPrior>,
    /// Posteriors that are priors, with how well a density describes them.
    pub(super) priors: Vec<PriorOfDraws>,
}

/// What is known when a stage begins.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Known {
    /// Nothing: the effects are to be screened.
    Nothing,
    /// Sets of effects are to be fitted.
    Refit(Box<State>),
    /// More sets are to be sought.
    Extend(Box<State>),
    /// Everything is fitted.
    Conclude(Box<State>),
}

/// What a block found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Partial {
    /// After the screening.
    State(Box<State>),
    /// After further sets were sought.
    Extended(Extended),
    /// Of each set.
    Refits(Vec<Result<Refit, Unfitted>>),
    /// The diagnosis.
    Output(Box<Output>),
}

/// What is known after further sets were sought, without the fits that were known before: there are many, and each is long.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Extended {
    /// All but the fits.
    state: Box<State>,
    /// The fits.
    refits: Vec<KnownOrNew>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum KnownOrNew {
    /// Position among those that were known before.
    Known(usize),
    New(Box<Refit>),
}

impl Extended {
    fn new(before: &State, mut state: State) -> Self {
        let of = |refit: Refit| match before.refits.iter().position(|known| *known == refit) {
            Some(place) => KnownOrNew::Known(place),
            None => KnownOrNew::New(Box::new(refit)),
        };
        let refits = std::mem::take(&mut state.refits).into_iter().map(of).collect();
        Self { state: Box::new(state), refits }
    }

    /// What is known, by what was known before. `None` of a fit that was not.
    fn beside(self, before: &State) -> Option<Box<State>> {
        let of = |refit| match refit {
            KnownOrNew::Known(place) => before.refits.get(place).cloned(),
            KnownOrNew::New(refit) => Some(*refit),
        };
        let refits = self.refits.into_iter().map(of).collect::<Option<_>>()?;
        Some(Box::new(State { refits, ..*self.state }))
    }
}

impl Diagnose {
    /// Prepares the job; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// A baseline model that no likelihood can be made of.
    pub fn new(spec: Spec, problem: Problem, seed: u64, name: &str) -> Result<Self, JobError> {
        let problem = problem.with_something_to_infer();
        problem.hypothesis(&[], 1.0).and_then(|baseline| baseline.likelihood(&problem)).map_err(failed)?;
        let key = StreamKey::new(seed, name, "diagnose");
        let diagnosis = Diagnosis::new(problem, spec.settings.clone(), key);
        Ok(Self { diagnosis, spec, posterior_priors: Vec::new(), priors: Vec::new() })
    }

    /// The same with posteriors in place of the priors of some parameters. Those without draws yet count for the job's
    /// identity alone. Of a posterior of more parameters than are inferred here, the others are averaged over.
    ///
    /// # Errors
    /// Draws that no density describes, with what deviates.
    pub fn with_posterior_priors(self, posterior_priors: Vec<PosteriorPrior>) -> Result<Self, JobError> {
        let problem = self.diagnosis.problem();
        let (mut joint, mut priors) = (Vec::new(), Vec::new());
        for posterior_prior in posterior_priors.iter().filter(|posterior_prior| !posterior_prior.draws.is_empty()) {
            let density = posterior_prior.density(&problem.parameters, &problem.priors).map_err(|error| {
                JobError::Failed(format!("the posterior of {} cannot be a prior here: {error}", posterior_prior.source))
            })?;
            let Some(density) = density else { continue };
            let name = |&place: &usize| problem.model.parameters[problem.parameters[place]].name.clone();
            priors.push(PriorOfDraws {
                source: posterior_prior.source.clone(),
                parameters: density.places().iter().map(name).collect(),
                draws: posterior_prior.draws.len() as u64,
                effective: posterior_prior.effective,
                converged: posterior_prior.converged,
                fit: density.fit().clone(),
            });
            joint.push(density);
        }
        let diagnosis = self.diagnosis.with_joint_priors(joint);
        Ok(Self { diagnosis, posterior_priors, priors, ..self })
    }

    /// What is stated of the priors beside the diagnosis.
    pub(super) fn finish(&self, mut output: Output) -> Output {
        for prior_of_draws in &self.priors {
            output.warnings.extend(prior_of_draws.fit.doubts.iter().map(|doubt| {
                format!(
                    "as a prior, the posterior of {} is described roughly by a normal distribution: {doubt}",
                    prior_of_draws.source
                )
            }));
            if !prior_of_draws.converged {
                output.converged = Some(false);
                output.warnings.push(format!(
                    "the prior is the posterior of {}, whose chains did not converge",
                    prior_of_draws.source
                ));
            }
        }
        output.posterior_priors.clone_from(&self.priors);
        output
    }

    pub(super) fn next(&self, state: Box<State>) -> Step<Self> {
        let requests = self.diagnosis.requests(&state);
        if requests.is_empty() {
            return Step::Blocks {
                stage: CONCLUDE.to_owned(),
                state: Known::Conclude(state),
                inputs: vec![Vec::new()],
            };
        }
        let sets = if self.diagnosis.problem().has_transients() { 1 } else { BLOCK };
        let inputs = requests.chunks(sets).map(<[FitRequest]>::to_vec).collect();
        Step::Blocks { stage: format!("{REFIT} {}", state.rounds), state: Known::Refit(state), inputs }
    }
}

/// Calls what fits many models: how far each fit has come says nothing of the block.
pub(super) fn quietly<T>(call: impl FnOnce() -> T) -> T {
    watch::with_share(&watch::Share::default(), call)
}

pub(super) fn failed(reason: impl std::fmt::Display) -> JobError {
    JobError::Failed(reason.to_string())
}

impl Job for Diagnose {
    type State = Known;
    /// Sets to fit; none in the other stages.
    type Input = Vec<FitRequest>;
    type Partial = Partial;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "diagnose"
    }

    fn algorithm_version(&self) -> u32 {
        71
    }

    fn identity(&self) -> Value {
        let problem = self.diagnosis.problem();
        let data: Vec<Value> = problem.measurements.iter().map(|measurement| measurement.identity()).collect();
        let effects: Vec<Value> = (self.spec.effects.iter())
            .filter_map(|name| problem.catalogue.get(name))
            .map(|effect| json!({ "name": effect.name, "file": effect.json }))
            .collect();
        let candidates: Vec<&str> = problem.candidates.iter().map(|candidate| candidate.id.as_str()).collect();
        let mut identity = json!({
            "parameters": self.spec.parameters,
            "settings": self.spec.settings,
            "effects": effects,
            "candidates": candidates,
            "model": problem.model.identity(),
            "priors": problem.priors,
            "input_errors": problem.input_errors,
            "data": data,
        });
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
        Ok(Step::Blocks { stage: SCREEN.to_owned(), state: Known::Nothing, inputs: vec![Vec::new()] })
    }

    fn block(&self, known: &Known, requests: Vec<FitRequest>, _parts: &dyn Parts) -> Result<Partial, JobError> {
        Ok(match known {
            Known::Nothing => Partial::State(Box::new(quietly(|| self.diagnosis.screen()).map_err(failed)?)),
            Known::Refit(state) => {
                let mut refits = Vec::with_capacity(requests.len());
                for (done, request) in requests.iter().enumerate() {
                    watch::at(done as u64, requests.len() as u64);
                    refits.push(quietly(|| self.diagnosis.refit(state, request)));
                }
                Partial::Refits(refits)
            }
            Known::Extend(state) => {
                Partial::Extended(Extended::new(state, quietly(|| self.diagnosis.extend(State::clone(state)))))
            }
            Known::Conclude(state) => Partial::Output(Box::new(quietly(|| self.diagnosis.conclude(state)))),
        })
    }

    fn memory_bytes(&self) -> u64 {
        self.diagnosis.memory_bytes()
    }

    fn is_last(&self, known: &Known) -> bool {
        matches!(known, Known::Conclude(_))
    }

    fn reduce(&self, known: Known, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let mut refits = Vec::new();
        for (_, partial) in blocks {
            match partial {
                Partial::State(state) => return Ok(self.next(state)),
                Partial::Extended(extended) => {
                    let before = match &known {
                        Known::Extend(before) => extended.beside(before),
                        _ => None,
                    };
                    return match before {
                        Some(state) => Ok(self.next(state)),
                        None => Err(unreadable(EXTEND, "it names a fit that is not there")),
                    };
                }
                Partial::Output(output) => return Ok(Step::Done(Box::new(self.finish(*output)))),
                Partial::Refits(block_refits) => refits.extend(block_refits),
            }
        }
        match known {
            Known::Refit(mut state) if refits.len() == state.pending.len() => {
                state.take(refits);
                let stage = format!("{EXTEND} {}", state.rounds);
                Ok(Step::Blocks { stage, state: Known::Extend(state), inputs: vec![Vec::new()] })
            }
            _ => Err(JobError::Failed("there is not one fit for each set".to_owned())),
        }
    }
}
