//! Measurements that are pinned by their hash: checked, or brought to their place.

use std::path::PathBuf;

use super::output::shown;
use super::status::Failure;
use crate::batch;
use crate::study::pinned::{self, Obtained, Sources, State};
use crate::study::{Folder, Reader};

/// A pinned measurement, checked or brought.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(super) struct PinnedFile {
    /// Its file.
    pub file: String,
    /// What is the matter with it, or where it was had from.
    pub state: String,
    /// Whether the right bytes are there.
    pub good: bool,
}

/// Checks pinned measurements, or brings them where it is stated from where.
///
/// # Errors
/// What is wrong with the files.
pub(super) fn pinned(paths: &[PathBuf], from: Option<&Sources>) -> Result<Vec<PinnedFile>, Failure> {
    let mut pinned_files: Vec<PinnedFile> = Vec::new();
    for (study, _, pass) in batch::passes(&Reader::new(crate::job::kinds()), paths, false)? {
        let folder = Folder::open(&study).map_err(|error| Failure::input(error.to_string()))?;
        for entry in &pass.pinned {
            let file = study.join(&entry.file).display().to_string();
            if pinned_files.iter().any(|listed_file| listed_file.file == file) {
                continue;
            }
            let (state, good) = if let Some(from) = from {
                match pinned::get(&folder, entry, from) {
                    Ok(Obtained::AlreadyThere) => ("already there".to_owned(), true),
                    Ok(Obtained::Copied(path)) => (format!("copied from {}", shown(&path)), true),
                    Ok(Obtained::Fetched(origin)) => (format!("fetched from {origin}"), true),
                    Err(error) => (error.to_string(), false),
                }
            } else {
                match pinned::verify(&folder, entry) {
                    Ok(State::Good) => ("the pinned bytes".to_owned(), true),
                    Ok(State::Absent) => ("not there".to_owned(), false),
                    Ok(State::Other { sha256 }) => (format!("other bytes, SHA-256 {sha256}"), false),
                    Err(error) => (error.to_string(), false),
                }
            };
            pinned_files.push(PinnedFile { file, state, good });
        }
    }
    Ok(pinned_files)
}
