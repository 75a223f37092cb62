//! What samplers return: draws with their densities, and what the chain went through.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::inference::posterior::{Density, Evaluator, Posterior, Work};
use crate::inference::prior::transform::TransformError;
use crate::inference::target::{Rejections, Target};
use crate::random::Stream;

/// That nothing could begin.
fn no_start(tries: u64, reason: &str) -> String {
    if tries == 1 {
        return format!("it could not be evaluated where its fit begins: {reason}");
    }
    format!("none of {tries} starting points could be evaluated; most frequent reason: {reason}")
}

/// Why there is no chain.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SampleError {
    /// A prior that cannot be sampled.
    #[error(transparent)]
    Transform(#[from] TransformError),
    /// No point with a finite posterior density.
    #[error("{}", no_start(*tries, reason))]
    NoStart {
        /// Points tried.
        tries: u64,
        /// The most frequent reason.
        reason: String,
    },
    /// A setting out of its range.
    #[error("the setting {setting} is {value}; accepted: {accepted}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What is accepted.
        accepted: &'static str,
    },
}

impl SampleError {
    /// Refuses a setting unless it is accepted.
    pub(super) fn check(
        setting: &'static str,
        value: f64,
        good: bool,
        accepted: &'static str,
    ) -> Result<(), SampleError> {
        if good { Ok(()) } else { Err(Self::Setting { setting, value, accepted }) }
    }
}

/// How a chain's moves went.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moves {
    /// Mean acceptance probability after warm-up (of the first proposals where a second may follow).
    pub acceptance: f64,
    /// Share of second proposals that were accepted; delayed rejection only.
    pub second_acceptance: Option<f64>,
    /// Transitions after warm-up that ended in a divergence of the trajectory's energy; trajectories only.
    pub divergences: u64,
    /// Transitions after warm-up that reached the greatest depth; trajectories only.
    pub depth_limited: u64,
    /// Step size after warm-up; trajectories only.
    pub step_size: Option<f64>,
}

/// One chain (or island of particles).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// Number of parameters.
    pub dimension: usize,
    /// Draws after warm-up, SI: `draws x parameters`, draw by draw.
    pub draws: Vec<f64>,
    /// Log likelihood at each draw.
    pub log_likelihoods: Vec<f64>,
    /// How the moves went.
    pub moves: Moves,
    /// Evaluations, warm-up included.
    pub work: Work,
}

impl Chain {
    /// An empty chain with room for draws.
    pub(super) fn with_capacity(dimension: usize, draws: usize) -> Self {
        Self {
            dimension,
            draws: Vec::with_capacity(dimension * draws),
            log_likelihoods: Vec::with_capacity(draws),
            ..Self::default()
        }
    }

    /// Appends the draw at coordinates.
    pub(super) fn push<T: Target>(&mut self, posterior: &Posterior<'_, T>, coordinates: &[f64], density: &Density) {
        let first = self.draws.len();
        self.draws.resize(first + coordinates.len(), 0.0);
        posterior.write_parameters(coordinates, &mut self.draws[first..]);
        self.log_likelihoods.push(density.log_likelihood);
    }

    /// Number of draws.
    pub fn len(&self) -> usize {
        self.log_likelihoods.len()
    }

    /// Whether there are no draws.
    pub fn is_empty(&self) -> bool {
        self.log_likelihoods.is_empty()
    }

    /// The draws of one parameter.
    pub fn parameter(&self, index: usize) -> Vec<f64> {
        self.draws.iter().skip(index).step_by(self.dimension.max(1)).copied().collect()
    }

    /// One draw.
    pub fn draw(&self, index: usize) -> &[f64] {
        &self.draws[index * self.dimension..(index + 1) * self.dimension]
    }
}

/// Chains of one posterior, equally long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chains {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// The chains.
    pub chains: Vec<Chain>,
}

impl Chains {
    /// Draws of one parameter, a vector a chain.
    pub fn parameter(&self, index: usize) -> Vec<Vec<f64>> {
        self.chains.iter().map(|chain| chain.parameter(index)).collect()
    }

    /// Number of draws of all chains.
    pub fn len(&self) -> usize {
        self.chains.iter().map(Chain::len).sum()
    }

    /// Whether there are no draws.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What all chains spent.
    pub fn work(&self) -> Work {
        let mut work = Work::default();
        for chain in &self.chains {
            work.merge(&chain.work);
        }
        work
    }
}

/// A point at which a chain starts.
pub(super) struct StartPoint {
    /// Coordinates.
    pub coordinates: Vec<f64>,
    /// Density there.
    pub density: Density,
    /// Gradient there.
    pub gradient: Vec<f64>,
}

/// The given parameters (SI) if they can be evaluated, else the first of a hundred draws from the prior that can.
pub(super) fn start_point<T: Target>(
    posterior: &Posterior<'_, T>,
    evaluator: &mut Evaluator<'_, T>,
    stream: &mut Stream,
    given: Option<&[f64]>,
    with_gradient: bool,
) -> Result<StartPoint, SampleError> {
    const TRIES: u64 = 100;
    let mut gradient = vec![0.0; posterior.dimension()];
    for attempt in 0..TRIES {
        let coordinates = match given {
            Some(parameters) if attempt == 0 => posterior.coordinates(parameters),
            _ => posterior.draw_prior(stream),
        };
        let density = if with_gradient {
            evaluator.density_gradient(&coordinates, &mut gradient)
        } else {
            evaluator.density(&coordinates)
        };
        if let Some(density) = density {
            return Ok(StartPoint { coordinates, density, gradient });
        }
    }
    Err(SampleError::NoStart { tries: TRIES, reason: most_frequent(&evaluator.work.rejections) })
}

/// The most frequent reason, the first of equals.
pub(crate) fn most_frequent(rejections: &Rejections) -> String {
    let mut best: Option<&(String, u64)> = None;
    for entry in &rejections.by_reason {
        if best.is_none_or(|most| entry.1 > most.1) {
            best = Some(entry);
        }
    }
    best.map_or_else(|| "none was given".to_owned(), |(reason, _)| reason.clone())
}
