//! Which bytes a study was read from: what a report's manifest certifies.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::document::hash::sha256_hex;

/// The bytes of a file, by size and hash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Size.
    pub bytes: u64,
    /// SHA-256, lower-case hex.
    pub sha256: String,
}

impl Content {
    /// What these bytes are.
    pub fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, sha256: sha256_hex(bytes) }
    }
}

/// The files that were read so far, by their plain path within the study. Clones note in the same one.
#[derive(Clone, Debug, Default)]
pub(super) struct Ledger(Arc<Mutex<BTreeMap<String, Content>>>);

impl Ledger {
    /// One in which these files stand.
    pub(super) fn with(files: BTreeMap<String, Content>) -> Self {
        Self(Arc::new(Mutex::new(files)))
    }

    /// Notes what was read of a file; whether that is what was read of it before.
    pub fn note(&self, file: &str, content: Content) -> bool {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *files.entry(file.to_owned()).or_insert_with(|| content.clone()) == content
    }

    /// All files.
    pub(super) fn files(&self) -> BTreeMap<String, Content> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
