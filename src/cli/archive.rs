//! A pass's report with everything that an archive needs: the files that it is made of, the jobs behind it, their hashes.

use std::path::{Path, PathBuf};

use super::execute::{Executed, is_judge};
use super::status::Failure;
use super::studies::{LoadedPass, history, view_in};
use crate::report::assemble::Surroundings;
use crate::report::{self, FileHash};
use crate::runner::ENGINE_VERSION;
use crate::runner::manifest::Manifest;
use crate::study::Pass;

/// Renders the report of a pass into its own folder below `out` and gives that folder. A pass of whose jobs none has a
/// result, because its data are not here, gets no report.
///
/// # Errors
/// A result that cannot be rendered, a file that cannot be written.
pub fn render(pass: &LoadedPass, executed: &Executed, out: &Path) -> Result<Option<PathBuf>, Failure> {
    let failed = |error: String| Failure::job(format!("{}: {error}", pass.shown));
    if executed.results(pass).next().is_none() && !pass.not_run.is_empty() {
        return Ok(None);
    }
    let command = format!("bmv report {}", pass.shown);
    let mut manifest = Manifest::new(&command);
    let mut files = Vec::new();
    let lineage = lineage(pass, executed);
    let written: Vec<&Pass> = lineage.iter().map(|loaded| loaded.pass.as_ref()).collect();
    for (role, file) in input_files(&written) {
        let path = pass.study.join(&file);
        let record = crate::runner::manifest::hash_file(&path).map_err(|error| failed(error.to_string()))?;
        files.push(FileHash { path: file, sha256: record.sha256.as_str().to_owned(), role: role.to_owned() });
        manifest.add_input_record(&path.display().to_string(), record);
    }
    for (position, job) in executed.results(pass) {
        manifest.add_job(&executed.plan.nodes()[position], job);
    }
    for parent in lineage.iter().filter(|other| other.file != pass.file) {
        for (position, job) in executed.results(parent) {
            let node = &executed.plan.nodes()[position];
            if is_judge(&parent.pass, &node.name) {
                manifest.add_job(node, job);
            }
        }
    }
    let engine_version = ENGINE_VERSION.to_string();
    let history = Some(history(&lineage, executed)?);
    let surroundings = Surroundings { files, engine_version, command, history, ..Surroundings::default() };
    let view = view_in(pass, executed, surroundings)?;
    let rendered = report::render(&view).map_err(|error| failed(error.to_string()))?;
    let folder = out.join(&view.study).join(pass.file.trim_end_matches(".json"));
    report::write(&rendered, &folder).map_err(|error| failed(error.to_string()))?;
    manifest.add_outputs(&folder)?;
    manifest.write(&folder)?;
    Ok(Some(folder))
}

/// A pass with those of its parents that were loaded.
fn lineage<'e>(pass: &'e LoadedPass, executed: &'e Executed) -> Vec<&'e LoadedPass> {
    let all = || executed.passes.iter().chain(&executed.parents);
    let find = |file: &String| all().find(|other| other.study == pass.study && other.file == *file);
    pass.pass.parents.iter().rev().filter_map(find).chain([pass]).collect()
}

/// A study's name: that of its folder.
pub(super) fn study_name(folder: &Path) -> String {
    let resolved = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    resolved.file_name().map_or_else(|| "study".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Files of the study that a pass and its parents are made of, with their roles; the pass stands last.
fn input_files(lineage: &[&Pass]) -> Vec<(&'static str, String)> {
    let mut files: Vec<(&'static str, String)> = Vec::new();
    for pass in lineage.iter().rev() {
        let mut own = vec![("model", pass.model_file.clone())];
        let is_first = files.is_empty();
        own.extend(is_first.then(|| ("pass", pass.file.clone())));
        own.extend(pass.parents.iter().map(|parent| ("parent pass", parent.clone())));
        own.extend(pass.adopted.iter().filter_map(|adopted| Some(("effect", adopted.file.clone()?))));
        own.extend(pass.measurements.iter().map(|measurement| ("data", measurement.file.clone())));
        let draws = pass.handed_on.iter().filter(|own| own.draws.sha256.is_some());
        own.extend(draws.map(|own| ("draws", own.draws.source.trim_matches('`').to_owned())));
        for upstream in &pass.upstream {
            let behind = input_files(&[upstream]).into_iter();
            own.extend(behind.map(|(role, file)| match role {
                "pass" => ("pass whose posterior is used", file),
                role => (role, file),
            }));
        }
        for (role, file) in own {
            if !files.iter().any(|(_, known)| *known == file) {
                files.push((role, file));
            }
        }
    }
    files
}
