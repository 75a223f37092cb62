//! Keys: what decides a result, hashed.
//!
//! The key of a job is the SHA-256 of the canonical JSON of [`KeyMaterial`], a struct of named fields; a new input of a
//! job is a new named field. The identity of a block is the SHA-256 of the job's key, the stage, the block's index and the
//! SHA-256 of its input, under the version of their form. Never part of either: time, threads, paths, host.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::error::RunnerError;
use crate::document::{canonical, hash};

/// Version of the numeric engine: raised when any change of the shared numeric code (solvers, streams, distributions,
/// reductions) moves any result. A single job kind's change raises that kind's own `algorithm_version` instead.
pub const ENGINE_VERSION: u32 = 5;

/// Version of the form in which blocks are stored; those of another form are not looked for.
const BLOCK_VERSION: u32 = 3;

/// A SHA-256 in 64 lower-case hexadecimal digits: the name of an object in the cache.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Key(String);

impl Key {
    /// Hash of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(hash::sha256_hex(bytes))
    }

    /// The 64 digits.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The first 12 digits, for people.
    pub fn short(&self) -> &str {
        self.0.get(..12).unwrap_or(&self.0)
    }

    /// The 32 bytes of a digest as digits.
    pub(super) fn from_digest(digest: &[u8]) -> Self {
        Self(hash::hex(digest))
    }
}

impl TryFrom<String> for Key {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text.len() == 64 && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b)) {
            Ok(Self(text))
        } else {
            Err(format!("`{text}` is not a key (64 digits of 0-9 and a-f)"))
        }
    }
}

impl From<Key> for String {
    fn from(key: Key) -> Self {
        key.0
    }
}

impl fmt::Display for Key {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Everything that decides a job's result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyMaterial {
    /// Kind of the job.
    pub kind: String,
    /// Version of that kind's algorithm.
    pub algorithm_version: u32,
    /// Version of the numeric engine, [`ENGINE_VERSION`].
    pub engine_version: u32,
    /// The study's seed.
    pub seed: u64,
    /// Name of the job: random streams are keyed by it.
    pub name: String,
    /// What the job says decides its result.
    pub identity: Value,
    /// Keys of the jobs whose results it uses, in the order in which it uses them.
    pub upstream: Vec<Key>,
}

impl KeyMaterial {
    /// The job's key.
    ///
    /// # Errors
    /// [`RunnerError::NotCanonical`] if the identity has no canonical form.
    pub fn key(&self) -> Result<Key, RunnerError> {
        Ok(Key::of(&canonical_bytes(&self.value()?, &format!("the identity of job `{}`", self.name))?))
    }

    /// The text that `bmv cache why` prints: what was hashed, indented.
    ///
    /// # Errors
    /// [`RunnerError::NotCanonical`] if the identity has no canonical form.
    pub fn explain(&self) -> Result<String, RunnerError> {
        serde_json::to_string_pretty(&self.value()?).map_err(|error| self.not_canonical(&error))
    }

    fn value(&self) -> Result<Value, RunnerError> {
        serde_json::to_value(self).map_err(|error| self.not_canonical(&error))
    }

    fn not_canonical(&self, error: &serde_json::Error) -> RunnerError {
        RunnerError::NotCanonical { what: format!("the identity of job `{}`", self.name), reason: error.to_string() }
    }
}

/// Identity of a block; `known` are the SHA-256 of what it works on: of the state of its stage and of its own input.
pub fn block_key(job: &Key, stage: &str, index: usize, known: [[u8; 32]; 2]) -> Key {
    let mut hash = Sha256::new();
    hash.update(BLOCK_VERSION.to_le_bytes());
    hash.update(job.as_str());
    // The length keeps the stage's name apart from what follows it.
    hash.update((stage.len() as u64).to_le_bytes());
    hash.update(stage);
    hash.update((index as u64).to_le_bytes());
    known.iter().for_each(|digest| hash.update(digest));
    Key::from_digest(&hash.finalize())
}

/// Name of what jobs share: it follows from these bytes alone.
pub fn shared_key(of: &[u8]) -> Key {
    let mut hash = Sha256::new();
    hash.update(b"shared");
    hash.update(BLOCK_VERSION.to_le_bytes());
    hash.update(of);
    Key::from_digest(&hash.finalize())
}

/// Canonical bytes of a value; `what` names it in the error.
pub(crate) fn canonical_bytes(value: &Value, what: &str) -> Result<Vec<u8>, RunnerError> {
    canonical::canonical(value)
        .map(String::into_bytes)
        .map_err(|error| RunnerError::NotCanonical { what: what.to_owned(), reason: error.to_string() })
}
