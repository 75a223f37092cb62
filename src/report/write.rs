//! Writing a rendered report to a folder.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::RenderedReport;

/// Why a report could not be written.
#[derive(Debug, Error)]
#[error("cannot write `{}`: {source}", path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why.
    source: std::io::Error,
}

/// Writes `report.md`, `report.html`, `results.json` and `plots/*.svg` into `folder`, which is made if needed.
/// Plots of an earlier report that this one does not have are removed. Returns the files, relative to the folder.
pub fn write(report: &RenderedReport, folder: &Path) -> Result<Vec<PathBuf>, WriteError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        |source| WriteError { path, source }
    };
    let plots = folder.join("plots");
    std::fs::create_dir_all(&plots).map_err(failed(&plots))?;
    for entry in std::fs::read_dir(&plots).map_err(failed(&plots))?.flatten() {
        let path = entry.path();
        let is_ours = report.figures.iter().any(|(name, _)| path.file_stem().is_some_and(|stem| stem == name.as_str()));
        if path.extension().is_some_and(|e| e == "svg") && !is_ours {
            std::fs::remove_file(&path).map_err(failed(&path))?;
        }
    }
    let mut files = vec![
        (PathBuf::from("report.md"), &report.markdown),
        (PathBuf::from("report.html"), &report.html),
        (PathBuf::from("results.json"), &report.results_json),
    ];
    files.extend(report.figures.iter().map(|(name, svg)| (Path::new("plots").join(format!("{name}.svg")), svg)));
    let mut written = Vec::with_capacity(files.len());
    for (relative, contents) in files {
        let path = folder.join(&relative);
        std::fs::write(&path, contents).map_err(failed(&path))?;
        written.push(relative);
    }
    Ok(written)
}
