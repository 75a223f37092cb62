//! Metropolis with proposals that do not depend on where the chain stands (Tierney 1994, Annals of Statistics 22, 1701, 2.3.3):
//! from a multivariate t density about a normal approximation of the posterior.
//!
//! A likelihood and no gradient a draw, where trajectories take several gradients; a proposal is accepted with
//! `min(1, w(y) / w(x))`, `w` posterior over proposal. Of use where likelihoods are costly and tell so much that the posterior
//! is nearly normal, as with long records. Where it is not, a chain stays long at points of great weight, which split R-hat and
//! effective samples show.

use serde::{Deserialize, Serialize};

use crate::inference::posterior::{Density, Posterior};
use crate::inference::prior::triangular_transport::NormalApproximation;
use crate::inference::sampler::chains::{Chain, SampleError, start_point};
use crate::inference::sampler::nuts::in_coordinates;
use crate::inference::sampler::parts::Parts;
use crate::inference::sampler::student::StudentProposal;
use crate::inference::target::Target;
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::random::StreamKey;
use crate::watch;

/// Settings of independence Metropolis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IndependenceSettings {
    /// Steps that are dropped.
    pub warm_up: u64,
    /// Draws kept, one a step.
    pub draws: u64,
    /// Degrees of freedom of the proposal, 1 or more.
    pub degrees: u32,
    /// Factor of the proposal's squared scale over the covariance of the normal approximation, above 0.
    pub widening: f64,
    /// The normal approximation.
    pub normal: NormalApproximation,
}

impl IndependenceSettings {
    /// The usual settings about a normal approximation.
    pub fn about(normal: NormalApproximation) -> Self {
        Self { warm_up: 100, draws: 2000, degrees: 5, widening: 1.2, normal }
    }

    fn check(&self, dimension: usize) -> Result<(), SampleError> {
        let check = SampleError::check;
        check("draws", self.draws as f64, self.draws > 0, "1 or more")?;
        check("degrees", f64::from(self.degrees), self.degrees >= 1, "1 or more")?;
        check("widening", self.widening, self.widening > 0.0 && self.widening.is_finite(), "above 0")?;
        let fits = self.normal.mode.len() == dimension && self.normal.covariance.len() == dimension * dimension;
        check("normal", self.normal.mode.len() as f64, fits, "as many parameters as are sampled")
    }
}

/// A chain on its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IndependenceState {
    /// Steps done.
    steps: u64,
    /// Place in the chain's stream of random numbers.
    words: u64,
    coordinates: Vec<f64>,
    density: Density,
    /// Logarithm of posterior over proposal.
    log_weight: f64,
    /// Proposals accepted after the warm-up.
    accepted: u64,
    /// The draws so far, and the work.
    chain: Chain,
}

/// Runs one chain; `start` (SI) is tried first, then draws from the prior.
///
/// # Errors
/// [`SampleError`] for a prior without a map, settings out of range, a covariance without a factor, or no point to start from.
pub fn sample<T: Target>(
    target: &T,
    settings: &IndependenceSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
) -> Result<Chain, SampleError> {
    Parts::none(|parts| sample_in_parts(target, settings, key, chain, start, parts))
}

/// The same chain, which keeps its state on the way and goes on from one that was kept.
///
/// # Errors
/// As [`sample`].
pub fn sample_in_parts<T: Target>(
    target: &T,
    settings: &IndependenceSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
    parts: &mut Parts<'_, IndependenceState>,
) -> Result<Chain, SampleError> {
    let dimension = target.dimension();
    settings.check(dimension)?;
    let posterior = Posterior::along(target, &settings.normal)?;
    let mut factor = in_coordinates(&settings.normal, &posterior);
    factor.iter_mut().for_each(|value| *value *= settings.widening);
    let is_definite = cholesky::factor(&mut factor, dimension).is_ok();
    SampleError::check("normal", f64::NAN, is_definite, "a positive definite covariance")?;
    let centre = posterior.coordinates(&posterior.inner_parameters(&settings.normal.mode));
    let mut proposal = StudentProposal::new(centre, factor, settings.degrees);
    let mut stream = key.stream(chain);
    let mut evaluator = posterior.evaluator();
    let (mut coordinates, mut density, mut log_weight, mut accepted, mut result, first);
    match parts.from.take() {
        Some(state) => {
            stream.seek(state.words);
            evaluator.work = state.chain.work.clone();
            (coordinates, density, log_weight) = (state.coordinates, state.density, state.log_weight);
            (accepted, result, first) = (state.accepted, state.chain, state.steps);
        }
        None => {
            let start = start_point(&posterior, &mut evaluator, &mut stream, start, false)?;
            log_weight = start.density.total() - proposal.log_density(&start.coordinates);
            (coordinates, density) = (start.coordinates, start.density);
            (accepted, result, first) = (0, Chain::with_capacity(dimension, settings.draws as usize), 0);
        }
    }
    let mut proposed = vec![0.0; dimension];
    let steps = settings.warm_up + settings.draws;
    for step in first..steps {
        watch::at(step, steps);
        let log_proposal = proposal.draw(&mut stream, &mut proposed);
        let chance = ln(stream.uniform());
        if let Some(there) = evaluator.density(&proposed) {
            let weight = there.total() - log_proposal;
            if chance < weight - log_weight {
                (density, log_weight) = (there, weight);
                std::mem::swap(&mut coordinates, &mut proposed);
                accepted += u64::from(step >= settings.warm_up);
            }
        }
        if step >= settings.warm_up {
            result.push(&posterior, &coordinates, &density);
        }
        parts.at(step + 1, steps, || IndependenceState {
            steps: step + 1,
            words: stream.position(),
            coordinates: coordinates.clone(),
            density,
            log_weight,
            accepted,
            chain: Chain { work: evaluator.work.clone(), ..result.clone() },
        });
    }
    result.moves.acceptance = accepted as f64 / settings.draws as f64;
    result.work = evaluator.work.clone();
    Ok(result)
}
