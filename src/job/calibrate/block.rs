//! Blocks of a calibration: what each is given and gives back.

use serde::{Deserialize, Serialize};

use super::output::Output;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::sampler::chains::Chain;
use crate::inference::sampler::importance::ImportanceEstimate;
use crate::inference::sampler::smc::Island;
use crate::job::{JobError, stored};

/// What is known when a stage begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum State {
    /// Nothing: the most probable point is sought.
    Nothing,
    /// The most probable point: the posterior is sampled.
    Sample(Box<PointEstimate>),
    /// The result but for the predictive checks.
    Predict(Box<Output>),
}

/// What a block does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Task {
    /// The most probable point.
    Estimate,
    /// A chain from a start.
    Chain {
        /// Which chain.
        index: u64,
        /// Where it starts, in inner parameters.
        start: Vec<f64>,
    },
    /// An island of particles.
    Island {
        /// Which island.
        index: u64,
    },
    /// The evidence by importance sampling.
    Evidence,
    /// What draws of the posterior or of the prior predict, SI.
    Predict {
        /// Whether the draws are of the prior.
        prior: bool,
        /// The draws: values by unknown.
        draws: Vec<Vec<f64>>,
    },
}

/// What it gives.
#[derive(Clone, Debug, PartialEq)]
pub enum Partial {
    /// The most probable point.
    Estimate(Box<PointEstimate>),
    /// A chain.
    Chain(Chain),
    /// An island of particles.
    Island(Box<Island>),
    /// Nothing where the weights allow no estimate.
    Evidence(Option<ImportanceEstimate>),
    /// What draws predict.
    Predicted(Predicted),
}

/// All but the long lists, whose lengths follow.
#[derive(Serialize, Deserialize)]
enum Head {
    Estimate(Box<PointEstimate>),
    Chain(Chain),
    Island(Box<Island>),
    Evidence(Option<ImportanceEstimate>),
    Predicted,
}

/// The head, then the lists.
impl stored::Block for Partial {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        let (head, lists) = match self {
            Self::Estimate(estimate) => (Head::Estimate(estimate), Default::default()),
            Self::Chain(mut chain) => {
                let lists = take(&mut chain);
                (Head::Chain(chain), lists)
            }
            Self::Island(mut island) => {
                let lists = take(&mut island.chain);
                (Head::Island(island), lists)
            }
            Self::Evidence(evidence) => (Head::Evidence(evidence), Default::default()),
            Self::Predicted(predicted) => {
                (Head::Predicted, [predicted.readings, predicted.pointwise, predicted.squares])
            }
        };
        stored::with_numbers(&(head, lists.each_ref().map(Vec::len)), &lists.concat())
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((head, lengths), numbers): ((Head, [usize; 3]), _) = stored::split_numbers(bytes, stage)?;
        let [first, second, third] = cut(&numbers, lengths, stage)?;
        Ok(match head {
            Head::Estimate(estimate) => Self::Estimate(estimate),
            Head::Chain(chain) => Self::Chain(Chain { draws: first, log_likelihoods: second, ..chain }),
            Head::Island(mut island) => {
                (island.chain.draws, island.chain.log_likelihoods) = (first, second);
                Self::Island(island)
            }
            Head::Evidence(evidence) => Self::Evidence(evidence),
            Head::Predicted => Self::Predicted(Predicted { readings: first, pointwise: second, squares: third }),
        })
    }
}

/// Lists of these lengths that stand one after the other.
fn cut<const N: usize>(numbers: &[f64], lengths: [usize; N], stage: &str) -> Result<[Vec<f64>; N], JobError> {
    if lengths.iter().try_fold(0_usize, |sum, length| sum.checked_add(*length)) != Some(numbers.len()) {
        return Err(stored::unreadable(stage, "it is cut off or too long"));
    }
    let mut values = numbers.iter().copied();
    Ok(lengths.map(|length| values.by_ref().take(length).collect()))
}

/// The long lists of a chain, taken out of it.
fn take(chain: &mut Chain) -> [Vec<f64>; 3] {
    [std::mem::take(&mut chain.draws), std::mem::take(&mut chain.log_likelihoods), Vec::new()]
}

/// What draws predict, draw by draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predicted {
    /// Readings of all measurements, rows and sensors; NaN where the model failed.
    pub readings: Vec<f64>,
    /// Log density of each datum of the fit.
    pub pointwise: Vec<f64>,
    /// Sum of squares of the whitened residuals, a draw each.
    pub squares: Vec<f64>,
}
