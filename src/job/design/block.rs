//! Blocks of a design: what each is given and gives back, a JSON text followed by numbers.

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::output::{Output, Phase};
use crate::inference::information::estimate::Replicate;
use crate::job::JobError;

/// A block of predictions: all samples of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PredictInput {
    pub candidate: usize,
}

/// What came out beside the predictions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PredictHead {
    /// Samples without a solution.
    pub failed: u64,
    /// Samples outside red, and outside yellow limits.
    pub outside: [u64; 2],
    /// How often each node was outside its red or yellow limits.
    pub nodes: Vec<u64>,
    /// Readings by unknowns at nominal parameters: change for one prior standard deviation, SI; empty where the nominal
    /// state has no solution.
    pub changes: Vec<f64>,
}

/// What a block of information is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Purpose {
    /// A candidate phase, alone or added to those that were picked.
    Phase,
    /// A sensor at the best candidate, added to those that were chosen.
    Sensor,
    /// A phase between the values of the grid: its readings are not known yet.
    Search,
    /// Nothing: it carries the result so far.
    Carry,
}

/// A block of information. The numbers behind it are the noise-free readings of its phases, one after the other:
/// `samples x sensors` each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct InformationInput {
    pub purpose: Purpose,
    /// Candidates whose phases are done together; the last is the new one.
    pub phases: Vec<usize>,
    /// Sensors that are read.
    pub sensors: Vec<usize>,
    /// First replicate and number of replicates.
    pub replicates: [usize; 2],
    /// Phases that a search found: candidates after those of the settings.
    pub found: Vec<Phase>,
    /// The result so far.
    pub carry: Option<Box<Output>>,
    /// Its replicates.
    pub carried: Vec<Vec<Replicate>>,
}

impl InformationInput {
    /// The same without candidates and without what it carries.
    pub fn shell(&self) -> Self {
        Self {
            purpose: Purpose::Phase,
            phases: Vec::new(),
            sensors: self.sensors.clone(),
            replicates: self.replicates,
            found: Vec::new(),
            carry: None,
            carried: Vec::new(),
        }
    }
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct InformationOutput {
    /// Of a phase of a search, whose readings are the numbers behind it.
    pub head: Option<PredictHead>,
    pub replicates: Vec<Replicate>,
    pub solutions: u64,
}

/// Length of the text, the text, the numbers as little-endian doubles.
pub(super) fn to_bytes<T: Serialize>(head: &T, numbers: &[f64]) -> Result<Vec<u8>, JobError> {
    let text = serde_json::to_vec(head).map_err(|e| JobError::Failed(e.to_string()))?;
    let mut bytes = Vec::with_capacity(8 + text.len() + 8 * numbers.len());
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(&text);
    bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
    Ok(bytes)
}

/// Reads that form.
pub(super) fn from_bytes<T: DeserializeOwned>(bytes: &[u8], stage: &str) -> Result<(T, Vec<f64>), JobError> {
    let unreadable = |reason: &str| JobError::Unreadable { stage: stage.to_owned(), reason: reason.to_owned() };
    let (head, rest) = bytes.split_first_chunk::<8>().ok_or_else(|| unreadable("it is too short"))?;
    let length = usize::try_from(u64::from_le_bytes(*head)).map_err(|_| unreadable("its text is too long"))?;
    let (text, numbers) = rest.split_at_checked(length).ok_or_else(|| unreadable("its text is cut off"))?;
    let head = serde_json::from_slice(text).map_err(|e| unreadable(&e.to_string()))?;
    let (words, remainder) = numbers.as_chunks::<8>();
    if !remainder.is_empty() {
        return Err(unreadable("a number is cut off"));
    }
    Ok((head, words.iter().map(|w| f64::from_le_bytes(*w)).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_and_damage_is_seen() {
        let numbers = [1.5, -0.0, f64::MIN_POSITIVE];
        let bytes = to_bytes(&PredictInput { candidate: 3 }, &numbers).expect("bytes");
        let (head, back): (PredictInput, Vec<f64>) = from_bytes(&bytes, "s").expect("block");
        assert_eq!((head.candidate, back.as_slice()), (3, &numbers[..]));
        for cut in 0..bytes.len() {
            let short = from_bytes::<PredictInput>(&bytes[..cut], "s");
            assert!(short.is_err() || short.is_ok_and(|(_, back)| back.len() < 3), "cut at {cut}");
        }
    }
}
