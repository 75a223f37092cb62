//! Writing a rendered report to a folder.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::RenderedReport;
use crate::runner::{Manifest, RunnerError};
use crate::study::file::{self, Existing};

/// Why a report could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// One of its files.
    #[error("cannot write `{}`: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The manifest.
    #[error(transparent)]
    Manifest(#[from] RunnerError),
}

/// Writes `report.md`, `report.html`, `results.json`, `record.json`, `plots/*.svg`, `plots/*.csv`, `results/*.npy` and at last
/// the manifest, which gets them as its outputs, into the folder `relative` below `base`; it is made if needed. Files that the manifest of an earlier report
/// there names, and this report does not have, are removed; all others stay. Below `base` no link is followed.
///
/// # Errors
/// What the system refuses, and links.
pub fn write(report: &RenderedReport, mut manifest: Manifest, base: &Path, relative: &Path) -> Result<(), WriteError> {
    let failed = |path: &Path| {
        let path = base.join(path);
        |source| WriteError::File { path, source }
    };
    let folder = file::make_folder(base, relative).map_err(failed(relative))?;
    // What is no manifest names nothing.
    let earlier = Manifest::read(&folder).map(|earlier| earlier.outputs).unwrap_or_default();
    let files = report.files();
    for (name, bytes) in &files {
        let path = relative.join(name);
        file::write(base, &path, bytes, Existing::Replace).map_err(failed(&path))?;
        manifest.add_output(name, bytes);
    }
    for name in earlier.keys().filter(|name| !files.contains_key(*name)) {
        let path = relative.join(name);
        file::remove(base, &path).map_err(failed(&path))?;
    }
    Ok(manifest.write(base, relative)?)
}
