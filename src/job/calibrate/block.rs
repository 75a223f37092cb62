//! Blocks of a calibration: what each is given and gives back.

use serde::{Deserialize, Serialize};

use super::output::Output;
use crate::inference::chains::Chain;
use crate::inference::importance::ImportanceEstimate;
use crate::inference::point_estimate::PointEstimate;
use crate::inference::smc::Island;
use crate::job::{JobError, stored};

/// A chain, an island or the evidence, from the point estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SampleInput {
    pub estimate: PointEstimate,
    pub task: SampleTask,
}

/// What a block of sampling does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum SampleTask {
    /// A chain from a start.
    Chain { index: u64, start: Vec<f64> },
    /// An island of particles.
    Island { index: u64 },
    /// The evidence by importance sampling.
    Evidence,
}

/// What it gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum SampleOutput {
    Chain(Chain),
    Island(Box<Island>),
    /// Nothing where the weights allow no estimate.
    Evidence(Option<ImportanceEstimate>),
}

impl SampleOutput {
    /// Stored form: all but the chain's lists, then those.
    pub fn into_bytes(mut self) -> Result<Vec<u8>, JobError> {
        let lists = match &mut self {
            Self::Chain(chain) => take(chain),
            Self::Island(island) => take(&mut island.chain),
            Self::Evidence(_) => Default::default(),
        };
        stored::with_numbers(&(self, lists.each_ref().map(Vec::len)), &lists.concat())
    }

    /// Reads the stored form.
    pub fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((mut output, lengths), numbers): ((Self, [usize; 2]), _) = stored::split_numbers(bytes, stage)?;
        let lists = cut(&numbers, lengths, stage)?;
        match &mut output {
            Self::Chain(chain) => put(chain, lists),
            Self::Island(island) => put(&mut island.chain, lists),
            Self::Evidence(_) => {}
        }
        Ok(output)
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
fn take(chain: &mut Chain) -> [Vec<f64>; 2] {
    [&mut chain.draws, &mut chain.log_likelihoods].map(std::mem::take)
}

fn put(chain: &mut Chain, lists: [Vec<f64>; 2]) {
    [chain.draws, chain.log_likelihoods] = lists;
}

/// A block of predictive checks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum PredictInput {
    /// Draws of the posterior or of the prior, SI.
    Draws { prior: bool, draws: Vec<Vec<f64>> },
    /// The result so far, which the reduction completes.
    Carry(Box<Output>),
}

/// What draws predict, draw by draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Predicted {
    /// Readings of all measurements, rows and sensors; NaN where the model failed.
    pub readings: Vec<f64>,
    /// Log density of each datum of the fit.
    pub pointwise: Vec<f64>,
    /// Sum of squares of the whitened residuals, a draw each.
    pub squares: Vec<f64>,
}

impl Predicted {
    /// Stored form: the lengths, then the numbers.
    pub fn to_bytes(&self) -> Result<Vec<u8>, JobError> {
        let lists = [&self.readings, &self.pointwise, &self.squares];
        stored::with_numbers(&lists.map(Vec::len), &lists.map(Vec::as_slice).concat())
    }

    /// Reads the stored form.
    pub fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let (lengths, numbers): ([usize; 3], _) = stored::split_numbers(bytes, stage)?;
        let [readings, pointwise, squares] = cut(&numbers, lengths, stage)?;
        Ok(Self { readings, pointwise, squares })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_come_back_from_bytes_and_damage_is_seen() {
        let chain = Chain {
            dimension: 2,
            draws: vec![1.0, f64::MIN_POSITIVE, 0.1, -0.0],
            log_likelihoods: vec![0.3, 1e300],
            ..Chain::default()
        };
        let bytes = SampleOutput::Chain(chain.clone()).into_bytes().expect("bytes");
        assert_eq!(SampleOutput::from_bytes(&bytes, "s"), Ok(SampleOutput::Chain(chain)));
        for cut in 0..bytes.len() {
            assert!(SampleOutput::from_bytes(&bytes[..cut], "s").is_err(), "cut at {cut}");
        }
    }

    #[test]
    fn predictions_come_back_from_bytes_and_damage_is_seen() {
        let predicted = Predicted { readings: vec![1.5, -0.0], pointwise: vec![2.5], squares: vec![300.0, 1.0] };
        let bytes = predicted.to_bytes().expect("bytes");
        assert_eq!(Predicted::from_bytes(&bytes, "s"), Ok(predicted));
        for cut in 0..bytes.len() {
            assert!(Predicted::from_bytes(&bytes[..cut], "s").is_err(), "cut at {cut}");
        }
    }
}
