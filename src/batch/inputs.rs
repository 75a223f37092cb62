//! The files that a pass was read from, each with its role and hash.

use std::collections::BTreeMap;

use crate::study::document::FILE as DOCUMENT;
use crate::study::inherit::plain_name;
use crate::study::{Content, Pass};

/// A file of a study: its role, its path within the study, what was read of it.
type InputFile = (&'static str, String, Content);

/// The files that were read of a study for a pass, its parents before it: those that the passes name, then all others.
pub(super) fn input_files(lineage: &[&Pass]) -> Result<Vec<InputFile>, String> {
    let mut read = BTreeMap::new();
    for pass in lineage {
        note(pass, &mut read)?;
    }
    let mut files: Vec<InputFile> = Vec::new();
    for (role, file) in named_files(lineage) {
        files.extend(read.remove(&file).map(|content| (role, file, content)));
    }
    files.extend(read.into_iter().map(|(file, content)| (role_by_folder(&file), file, content)));
    Ok(files)
}

/// The files that were read of a study for a pass.
///
/// # Errors
/// One that changed meanwhile.
pub(super) fn read_files(pass: &Pass) -> Result<BTreeMap<String, Content>, String> {
    let mut read = BTreeMap::new();
    note(pass, &mut read)?;
    Ok(read)
}

/// Adds what was read for a pass and those whose posteriors it uses.
fn note(pass: &Pass, read: &mut BTreeMap<String, Content>) -> Result<(), String> {
    for (file, content) in &pass.files {
        if read.insert(file.clone(), content.clone()).is_some_and(|before| before != *content) {
            return Err(format!("`{file}` changed while the study was read: run the command again"));
        }
    }
    pass.upstream.iter().try_for_each(|upstream| note(upstream, read))
}

/// What a file is that no pass names by itself.
fn role_by_folder(file: &str) -> &'static str {
    match file.split_once('/') {
        Some(("effects", _)) => "effect",
        Some(("rules", _)) => "rule",
        Some(("criteria", _)) => "criteria",
        None if file == DOCUMENT => "document",
        _ if file.ends_with(".json") => "pass named as evidence",
        _ => "data",
    }
}

/// Files that a pass and its parents name, with their roles; the pass stands last.
fn named_files(lineage: &[&Pass]) -> Vec<(&'static str, String)> {
    let mut files: Vec<(&'static str, String)> = Vec::new();
    for pass in lineage.iter().rev() {
        let mut pass_files = vec![("model", pass.model_file.clone())];
        let is_first = files.is_empty();
        pass_files.extend(is_first.then(|| ("pass", pass.file.clone())));
        pass_files.extend(pass.parents.iter().map(|parent| ("parent pass", parent.clone())));
        pass_files.extend(pass.adopted.iter().filter_map(|adopted| Some(("effect", adopted.file.clone()?))));
        pass_files.extend(pass.measurements.iter().map(|measurement| ("data", measurement.file.clone())));
        let draws = pass.posterior_priors.iter().filter(|reference| reference.draws.sha256.is_some());
        pass_files.extend(draws.map(|reference| ("draws", reference.draws.source.trim_matches('`').to_owned())));
        for upstream in &pass.upstream {
            let behind = named_files(&[upstream]).into_iter();
            pass_files.extend(behind.map(|(role, file)| match role {
                "pass" => ("pass whose posterior is used", file),
                role => (role, file),
            }));
        }
        for (role, file) in pass_files {
            let file = plain_name(&file);
            if !files.iter().any(|(_, listed_file)| *listed_file == file) {
                files.push((role, file));
            }
        }
    }
    files
}
