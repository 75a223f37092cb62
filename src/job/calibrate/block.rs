//! Blocks of a calibration: what each is given and gives back.

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::output::Output;
use crate::inference::chains::Chain;
use crate::inference::importance::ImportanceEstimate;
use crate::inference::point_estimate::PointEstimate;
use crate::inference::smc::Island;
use crate::job::JobError;

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
    /// Stored form: the three lengths, then the numbers, little-endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        let all = [&self.readings, &self.pointwise, &self.squares];
        let mut bytes: Vec<u8> = all.iter().flat_map(|list| (list.len() as u64).to_le_bytes()).collect();
        bytes.extend(all.iter().flat_map(|list| list.iter()).flat_map(|value| value.to_le_bytes()));
        bytes
    }

    /// Reads the stored form.
    pub fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let unreadable =
            || JobError::Unreadable { stage: stage.to_owned(), reason: "it is cut off or too long".to_owned() };
        let (words, rest) = bytes.as_chunks::<8>();
        if words.len() < 3 || !rest.is_empty() {
            return Err(unreadable());
        }
        let mut values = words[3..].iter().map(|word| f64::from_le_bytes(*word));
        let mut lists = words[..3].iter().map(|word| {
            let count = usize::try_from(u64::from_le_bytes(*word)).unwrap_or(usize::MAX);
            let list: Vec<f64> = values.by_ref().take(count).collect();
            (list.len() == count).then_some(list).ok_or_else(unreadable)
        });
        let mut next = || lists.next().unwrap_or_else(|| Err(unreadable()));
        let (readings, pointwise, squares) = (next()?, next()?, next()?);
        Ok(Self { readings, pointwise, squares })
    }
}

/// JSON bytes of a block.
pub(super) fn to_bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, JobError> {
    serde_json::to_vec(value).map_err(|e| JobError::Failed(e.to_string()))
}

/// Reads JSON bytes of a block.
pub(super) fn from_bytes<T: DeserializeOwned>(bytes: &[u8], stage: &str) -> Result<T, JobError> {
    serde_json::from_slice(bytes).map_err(|e| JobError::Unreadable { stage: stage.to_owned(), reason: e.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn predictions_come_back_from_bytes_and_damage_is_seen() {
        let predicted = Predicted { readings: vec![1.5, -0.0], pointwise: vec![2.5], squares: vec![300.0, 1.0] };
        let bytes = predicted.to_bytes();
        assert_eq!(Predicted::from_bytes(&bytes, "s"), Ok(predicted));
        for cut in 0..bytes.len() {
            assert!(Predicted::from_bytes(&bytes[..cut], "s").is_err(), "cut at {cut}");
        }
    }
}
