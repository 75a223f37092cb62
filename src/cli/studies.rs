//! Where the verbs meet the rooms that load studies and render reports.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::status::Failure;
use crate::runner::{Node, Plan, RunSummary};

/// A pass that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadedPass {
    /// Path of the pass file, as people see it.
    pub shown: String,
    /// Folder of the study.
    pub study: PathBuf,
    /// Name of the pass file in it.
    pub file: String,
    /// Ids of its jobs, in the order of the file.
    pub jobs: Vec<String>,
}

/// Passes with their jobs, ready to plan.
#[derive(Default)]
pub struct Loaded {
    /// The passes that were asked for.
    pub passes: Vec<LoadedPass>,
    /// Their jobs, and those of other passes upon which they build.
    pub nodes: Vec<Node>,
    /// What people should know and what stops nothing: warnings, jobs that wait for data and the command that brings
    /// them.
    pub notes: Vec<String>,
}

/// A pinned measurement, checked or brought.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PinnedFile {
    /// Its file.
    pub file: String,
    /// What is the matter with it, or where it was had from.
    pub state: String,
    /// Whether the right bytes are there.
    pub good: bool,
}

/// Loads the passes found under these paths.
///
/// # Errors
/// What is wrong with the files, rendered at its place.
pub fn load(paths: &[PathBuf], coloured: bool) -> Result<Loaded, Failure> {
    let _ = coloured;
    Err(not_yet(&format!("load {} path(s)", paths.len())))
}

/// Renders the report of a pass into `out` and gives the files written.
///
/// # Errors
/// A result that cannot be rendered, a file that cannot be written.
pub fn render(pass: &LoadedPass, plan: &Plan, summary: &RunSummary, out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let _ = (plan, summary, out);
    Err(not_yet(&format!("render {}", pass.shown)))
}

/// Checks pinned measurements, or brings them first if `bring`; `from` is a folder to search.
///
/// # Errors
/// What is wrong with the files.
pub fn pinned(paths: &[PathBuf], bring: bool, from: Option<&Path>) -> Result<Vec<PinnedFile>, Failure> {
    let _ = (bring, from);
    Err(not_yet(&format!("look for data under {} path(s)", paths.len())))
}

/// JSON Schema of a file format: `model`, `pass`, `effect`, `results`. Nothing for a name that is none of them.
pub fn schema(format: &str) -> Option<Value> {
    let _ = format;
    None
}

fn not_yet(what: &str) -> Failure {
    Failure::input(format!("this build cannot {what}"))
}
