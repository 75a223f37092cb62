//! Finds studies and their passes under the paths that a user names.

use crate::math::sort::{sort_by, sort_by_key};
use std::path::{Component, Path, PathBuf};

use thiserror::Error;

use super::project::{missing, whole};

/// A study folder with its passes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The study's folder.
    pub folder: PathBuf,
    /// Its pass files (all, or the one named), in the order of their numbers.
    pub passes: Vec<PathBuf>,
}

/// Why nothing is found.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum DiscoverError {
    /// There is nothing at the path.
    #[error("{}", missing(path))]
    Missing {
        /// As given.
        path: PathBuf,
    },
    /// The folder holds no pass.
    #[error("no pass file (pass-1.json, pass-2.json, ...) under `{path}`")]
    NoPass {
        /// As given.
        path: String,
    },
    /// The file is no pass.
    #[error("`{path}` is not a JSON file: a pass is named pass-1.json, pass-2.json, ...")]
    NotAPass {
        /// As given.
        path: String,
    },
}

/// The studies under these paths, sorted by folder, each folder once however often and by whatever path it is named: a
/// path is a pass file, a study's folder, or a folder of such folders. Hidden folders and `target` are skipped. The
/// paths given back have no `.` in them; the folder where the user stands is the empty path.
///
/// # Errors
/// A path that does not exist or has no pass under it.
pub fn discover(paths: &[PathBuf]) -> Result<Vec<Found>, DiscoverError> {
    let mut studies: Vec<Found> = Vec::new();
    for path in paths {
        let shown = path.display().to_string();
        if path.is_dir() {
            let before = studies.len();
            let visible = |entry: &walkdir::DirEntry| {
                let name = entry.file_name().to_string_lossy();
                entry.depth() == 0 || !(name.starts_with('.') || name == "target")
            };
            for entry in walkdir::WalkDir::new(path).sort_by_file_name().into_iter().filter_entry(visible).flatten() {
                if entry.file_type().is_dir() {
                    let passes = passes(entry.path());
                    if !passes.is_empty() {
                        let passes = passes.iter().map(|pass| plain(pass)).collect();
                        studies.push(Found { folder: plain(entry.path()), passes });
                    }
                }
            }
            if studies.len() == before {
                return Err(DiscoverError::NoPass { path: shown });
            }
        } else if path.is_file() {
            if path.extension().is_none_or(|extension| extension != "json") {
                return Err(DiscoverError::NotAPass { path: shown });
            }
            let folder = path.parent().map_or_else(PathBuf::new, plain);
            studies.push(Found { folder, passes: vec![plain(path)] });
        } else {
            return Err(DiscoverError::Missing { path: path.clone() });
        }
    }
    sort_by(&mut studies, |a, b| a.folder.cmp(&b.folder));
    let mut merged: Vec<(PathBuf, Found)> = Vec::new();
    for study in studies {
        let place = whole(&study.folder);
        match merged.iter_mut().find(|(merged_place, _)| *merged_place == place) {
            Some((_, merged_study)) => {
                let names = study.passes.iter().filter_map(|pass| pass.file_name());
                merged_study.passes.extend(names.map(|name| merged_study.folder.join(name)));
            }
            None => merged.push((place, study)),
        }
    }
    let mut merged: Vec<Found> = merged.into_iter().map(|(_, study)| study).collect();
    for study in &mut merged {
        sort_by_key(&mut study.passes, |pass| (number(pass), pass.clone()));
        study.passes.dedup();
    }
    Ok(merged)
}

/// A path without `.`.
pub fn plain(path: &Path) -> PathBuf {
    path.components().filter(|part| *part != Component::CurDir).collect()
}

/// The pass files of a folder in the order of their numbers; none where it is no study.
pub fn passes(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut passes: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(|path| number(path).is_some() && path.is_file()).collect();
    sort_by_key(&mut passes, |pass| (number(pass), pass.clone()));
    passes
}

/// The number N of `pass-N.json`.
pub fn number(pass: &Path) -> Option<u64> {
    let digits = pass.file_name()?.to_str()?.strip_prefix("pass-")?.strip_suffix(".json")?;
    if digits.bytes().all(|byte| byte.is_ascii_digit()) { digits.parse().ok() } else { None }
}
