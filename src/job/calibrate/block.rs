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

impl SampleOutput {
    /// Stored form: the length of what is written as JSON, that, then the chain's numbers, little-endian, which would
    /// take thrice the room as text.
    pub fn into_bytes(mut self) -> Result<Vec<u8>, JobError> {
        let lists = match &mut self {
            Self::Chain(chain) => take(chain),
            Self::Island(island) => take(&mut island.chain),
            Self::Evidence(_) => Default::default(),
        };
        let text = to_bytes(&(&self, lists.each_ref().map(Vec::len)))?;
        let numbers: usize = lists.iter().map(Vec::len).sum();
        let mut bytes = Vec::with_capacity(8 + text.len() + 8 * numbers);
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text);
        for value in lists.iter().flatten() {
            bytes.extend(value.to_le_bytes());
        }
        Ok(bytes)
    }

    /// Reads the stored form.
    pub fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let unreadable =
            || JobError::Unreadable { stage: stage.to_owned(), reason: "it is cut off or too long".to_owned() };
        let (length, rest) = bytes.split_first_chunk::<8>().ok_or_else(unreadable)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| unreadable())?;
        let (text, rest) = rest.split_at_checked(length).ok_or_else(unreadable)?;
        let (mut output, lengths): (Self, [usize; 2]) = from_bytes(text, stage)?;
        let (words, left) = rest.as_chunks::<8>();
        let wanted = lengths.iter().try_fold(0_usize, |sum, length| sum.checked_add(*length));
        if !left.is_empty() || wanted != Some(words.len()) {
            return Err(unreadable());
        }
        let mut values = words.iter().map(|word| f64::from_le_bytes(*word));
        let lists = lengths.map(|length| values.by_ref().take(length).collect::<Vec<f64>>());
        match &mut output {
            Self::Chain(chain) => put(chain, lists),
            Self::Island(island) => put(&mut island.chain, lists),
            Self::Evidence(_) => {}
        }
        Ok(output)
    }
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
        let bytes = predicted.to_bytes();
        assert_eq!(Predicted::from_bytes(&bytes, "s"), Ok(predicted));
        for cut in 0..bytes.len() {
            assert!(Predicted::from_bytes(&bytes[..cut], "s").is_err(), "cut at {cut}");
        }
    }
}
