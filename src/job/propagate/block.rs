//! A block of samples: which it holds, and its result as bytes.

use serde::{Deserialize, Serialize};

use super::output::FailedSample;
use crate::job::{JobError, stored};

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

/// The failures, then the values.
impl stored::Block for BlockOutput {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        stored::with_numbers(&(self.failed, self.failures), &self.values)
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((failed, failures), values) = stored::split_numbers(bytes, stage)?;
        Ok(Self { values, failures, failed })
    }
}
