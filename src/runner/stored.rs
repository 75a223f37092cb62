//! A result in the cache: canonical JSON; then, where it has arrays, a line break and these as NPY files.

use std::sync::Arc;

use serde_json::Value;

use super::error::RunnerError;
use super::key::{Key, canonical_bytes};
use crate::job::array::Arrays;
use crate::job::stored::ResultDocument;

/// A verified result.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// The result.
    pub value: Arc<Value>,
    /// The numbers of its arrays.
    pub arrays: Arrays,
    /// SHA-256 of its canonical JSON, which holds those of the arrays.
    pub sha256: Key,
}

/// The bytes of a job's result.
///
/// # Errors
/// [`RunnerError::NotCanonical`] for a number without a text.
pub(super) fn bytes(result: &ResultDocument, job: &str) -> Result<Vec<u8>, RunnerError> {
    let mut bytes = canonical_bytes(&result.json, &what(job))?;
    if result.arrays != Arrays::default() {
        bytes.push(b'\n');
        result.arrays.write_npy(&mut bytes);
    }
    Ok(bytes)
}

fn what(job: &str) -> String {
    format!("the result of job `{job}`")
}

impl Stored {
    /// Reads a job's result. It is always read back from its bytes, so that it is the same value whether it was just
    /// computed or found.
    ///
    /// # Errors
    /// [`RunnerError::NotCanonical`] if they are no JSON, or no arrays follow.
    pub fn from_bytes(bytes: &[u8], job: &str) -> Result<Self, RunnerError> {
        let refused = |reason: String| RunnerError::NotCanonical { what: what(job), reason };
        // Canonical JSON has no line break.
        let end = bytes.iter().position(|&byte| byte == b'\n');
        let (json, arrays) = end.map_or((bytes, &[][..]), |end| (&bytes[..end], &bytes[end + 1..]));
        let value = serde_json::from_slice(json).map_err(|error| refused(error.to_string()))?;
        let arrays = Arrays::from_npy(arrays).map_err(|reason| refused(reason.to_owned()))?;
        Ok(Self { value: Arc::new(value), arrays, sha256: Key::of(json) })
    }
}
