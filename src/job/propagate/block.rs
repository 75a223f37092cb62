//! A block of samples: which it holds, and its result as bytes.

use serde::{Deserialize, Serialize};

use super::output::FailedSample;
use crate::job::JobError;

/// What a block is to do: small, and enough for any machine that has the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockInput {
    /// Position of the case (environment and design value).
    pub case: usize,
    /// First sample.
    pub first: u64,
    /// Number of samples.
    pub count: u64,
}

/// A block's result.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockOutput {
    /// Values by quantity, then sample; NaN where the solution failed.
    pub values: Vec<f64>,
    /// Failed samples with their inputs, the first few of the block.
    pub failures: Vec<FailedSample>,
    /// Number of failed samples.
    pub failed: u64,
}

impl BlockOutput {
    /// Stored form: length of the text, the text (failures as JSON), the values as little-endian doubles.
    pub fn to_bytes(&self) -> Result<Vec<u8>, JobError> {
        let text = serde_json::to_vec(&(self.failed, &self.failures))
            .map_err(|e| JobError::Failed(format!("the failed samples cannot be written: {e}")))?;
        let mut bytes = Vec::with_capacity(8 + text.len() + 8 * self.values.len());
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(&text);
        bytes.extend(self.values.iter().flat_map(|v| v.to_le_bytes()));
        Ok(bytes)
    }

    /// Reads the stored form.
    pub fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let unreadable = |reason: &str| JobError::Unreadable { stage: stage.to_owned(), reason: reason.to_owned() };
        let (head, rest) = bytes.split_first_chunk::<8>().ok_or_else(|| unreadable("it is too short"))?;
        let length = usize::try_from(u64::from_le_bytes(*head)).map_err(|_| unreadable("its text is too long"))?;
        let (text, values) = rest.split_at_checked(length).ok_or_else(|| unreadable("its text is cut off"))?;
        let (failed, failures) = serde_json::from_slice(text).map_err(|e| unreadable(&e.to_string()))?;
        let (words, remainder) = values.as_chunks::<8>();
        if !remainder.is_empty() {
            return Err(unreadable("a value is cut off"));
        }
        Ok(Self { values: words.iter().map(|w| f64::from_le_bytes(*w)).collect(), failures, failed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        let block = BlockOutput {
            values: vec![1.5, -0.0, f64::MIN_POSITIVE, 300.1],
            failures: vec![FailedSample { index: 7, parameters: vec![("a".into(), 0.1)], reason: "no".into() }],
            failed: 1,
        };
        let bytes = block.to_bytes().expect("bytes");
        assert_eq!(BlockOutput::from_bytes(&bytes, "samples").expect("block"), block);
        for cut in 0..bytes.len() {
            let short = BlockOutput::from_bytes(&bytes[..cut], "samples");
            assert!(short.is_err() || short.is_ok_and(|b| b != block), "cut at {cut}");
        }
    }
}
