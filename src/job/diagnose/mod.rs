//! Which physics the model is missing: the diagnosis (`crate::diagnosis`) as stages of blocks.
//!
//! Stages: `screen` (one block), then rounds of `refit N` (sets of effects, some a block) and `extend N` (one block),
//! then `conclude` (one block).

mod form;
mod resolve;
mod run;

pub use run::{Diagnose, Spec};

use std::sync::Arc;

use serde_json::Value;

use crate::diagnosis::{Output, PRIOR_OF, Problem};
use crate::job::JobError;
use crate::job::Runnable;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::job::ready::{after, filled, unfilled};
use crate::study::blocked::draws_among;
use crate::study::job::Inference;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::problem::problem_with;
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::resolved::PosteriorReference;
use crate::study::{self, Pass};
use form::DiagnoseForm;

/// Effects that are less probable are no key numbers of a diagnosis: they come and go with the last digit of a fit.
const LEAST_PROBABILITY: f64 = 0.01;

/// Change of a probability with another seed that counts: integrals over effects' sizes, and points at which fits of sets
/// begin, are drawn with it, which moves one by up to a few thousandths.
const PROBABILITY_TOLERANCE: f64 = 0.03;

/// The kind `diagnose`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "diagnose";
    const ABOUT: &'static str = "Which physical effect is missing.";
    type Form = DiagnoseForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &DiagnoseForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let number = |of: &str, statistic: &str, value: f64| {
            KeyNumber::searched(of, statistic, "", value, PROBABILITY_TOLERANCE)
        };
        let nothing = number("nothing", "probability", output.probability_nothing);
        let unexplained = number("something else", "probability", output.probability_unexplained);
        let effects = output.effects.iter().filter(|effect| effect.probability >= LEAST_PROBABILITY);
        let of_effect = effects.map(|effect| number(&effect.id, "probability of being missing", effect.probability));
        [nothing, unexplained].into_iter().chain(of_effect).collect()
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let problem = problem(spec, shared);
        let draws = draws_among(shared.pass, &spec.parameters);
        let unprepared = Diagnose::new(spec.clone(), problem.clone(), shared.pass.seed, name)?;
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(unprepared)));
        }
        let unprepared = unprepared.with_posterior_priors(
            unfilled(&draws).into_iter().map(|posterior_prior| posterior_prior.with_no_draws()).collect(),
        )?;
        let (references, spec, seed, name) = (draws.clone(), spec.clone(), shared.pass.seed, name.to_owned());
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let job = Diagnose::new(spec.clone(), problem.clone(), seed, &name)?;
            Ok(Arc::new(job.with_posterior_priors(filled(&references, &mut results.iter())?)?))
        };
        after(&[&draws], Arc::new(unprepared), Box::new(prepare))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn inference(&self) -> Option<Inference<'_>> {
        Some(Inference { verb: "diagnoses", data: &self.data, parameters: &self.parameters })
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        draws_among(pass, &self.parameters).iter().find_map(PosteriorReference::blocks)
    }
}

/// What is diagnosed.
fn problem(spec: &Spec, shared: &Shared) -> Problem {
    let measurements = spec.data.iter().map(|&index| shared.measurements[index].clone()).collect();
    let mut problem = problem_with(shared.pass, measurements, spec.parameters.clone());
    Arc::make_mut(&mut problem.candidates).retain(|candidate| spec.effects.contains(&candidate.effect));
    problem.considered.clone_from(&spec.effects);
    if !spec.effects.iter().any(|name| name == PRIOR_OF) {
        return problem;
    }
    // Those of adopted effects stand behind the model's own.
    let adopted = shared.pass.adopted.iter().map(|adopted| adopted.parameters.start).min();
    problem.with_priors_in_question(adopted.unwrap_or(usize::MAX))
}
