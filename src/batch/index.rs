//! The pages over the reports of a folder, written after each rendering: from what lies there, not from what the command
//! rendered, so that reports of a part of the studies leave the entries of the others as they are.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::BatchError;
use super::archive::Target;
use crate::math::sort::sort_by_key;
use crate::report::INDEX;
use crate::report::archive::record::{FILE_NAME as RECORD, Record};
use crate::report::archive::ro_crate::{self, FILE_NAME as CRATE};
use crate::report::archive::{ArchivedPass, ArchivedStudy, FORMAT, RenderedPage, index_page, is_listed, study_page};
use crate::report::terminal::escaped;
use crate::runner::Manifest;
use crate::runner::manifest::{FILE_NAME as MANIFEST, FileRecord};
use crate::study::discover::number;
use crate::study::file::{self, Existing};

/// Largest file that is read here, bytes.
const LARGEST: u64 = 64 << 20;

/// Writes the pages over the reports below the folders of these targets; gives the paths of the pages over all studies, and
/// what people should know.
///
/// # Errors
/// A folder that cannot be listed, a file that cannot be written.
pub fn write(targets: &[Target]) -> Result<(Vec<PathBuf>, Vec<String>), BatchError> {
    let folders: BTreeSet<(PathBuf, PathBuf)> = targets.iter().map(Target::reports).collect();
    let (mut pages, mut notes) = (Vec::new(), Vec::new());
    for (base, relative) in folders {
        let studies = read(&base.join(&relative), &mut notes)?;
        for study in &studies {
            let below = relative.join(&study.folder);
            match foreign(&base, &below, &[&page_names()[..], &[CRATE.to_owned()]].concat()) {
                Some(note) => notes.push(note),
                None => write_study(&base, &below, study, &studies)?,
            }
        }
        let archived: Vec<ArchivedStudy> = studies.into_iter().filter(is_kept).collect();
        if archived.is_empty() {
            continue;
        }
        match foreign(&base, &relative, &page_names()) {
            Some(note) => notes.push(note),
            None => {
                put(&base, &relative, &rendered(&index_page::page(&archived))?)?;
                pages.push(base.join(&relative).join(format!("{INDEX}.html")));
            }
        }
    }
    Ok((pages, notes))
}

/// Whether the reports of a study are kept with the others.
fn is_kept(study: &ArchivedStudy) -> bool {
    study.passes.iter().any(|pass| pass.record.is_archived())
}

fn write_study(base: &Path, relative: &Path, study: &ArchivedStudy, all: &[ArchivedStudy]) -> Result<(), BatchError> {
    let files = put(base, relative, &rendered(&study_page::page(study, all))?)?;
    let text = ro_crate::text(study, &files).map_err(|error| BatchError::job(error.to_string()))?;
    put_file(base, &relative.join(CRATE), text.as_bytes())
}

fn rendered(page: &crate::report::page::Page) -> Result<RenderedPage, BatchError> {
    RenderedPage::new(page).map_err(|error| BatchError::job(error.to_string()))
}

/// Names of a page in both forms.
fn page_names() -> [String; 2] {
    ["md", "html"].map(|ending| format!("{INDEX}.{ending}"))
}

/// That one of these files is there and was not written by the program, so that it stays.
fn foreign(base: &Path, folder: &Path, names: &[String]) -> Option<String> {
    let place = |name: &String| base.join(folder).join(name);
    let is_foreign = |name: &&String| match file::read(&place(name), LARGEST) {
        Ok(there) => !String::from_utf8_lossy(&there).contains(FORMAT),
        Err(error) => error.kind() != std::io::ErrorKind::NotFound,
    };
    names.iter().find(is_foreign).map(|name| {
        format!(
            "`{}` was not written by bmv and stays as it is, so that there is no index here: move it, or name another \
             folder with --out DIR",
            escaped(&place(name).display().to_string())
        )
    })
}

/// Writes a page in both forms; gives their records.
fn put(base: &Path, folder: &Path, page: &RenderedPage) -> Result<BTreeMap<String, FileRecord>, BatchError> {
    let mut files = BTreeMap::new();
    for (name, text) in page_names().into_iter().zip([&page.markdown, &page.html]) {
        put_file(base, &folder.join(&name), text.as_bytes())?;
        files.insert(name, FileRecord::of(text.as_bytes()));
    }
    Ok(files)
}

/// Writes a file, if it is another than what lies there.
fn put_file(base: &Path, relative: &Path, bytes: &[u8]) -> Result<(), BatchError> {
    let place = base.join(relative);
    if file::read(&place, LARGEST).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    file::write(base, relative, bytes, Existing::Replace)
        .map_err(|error| BatchError::job(format!("cannot write `{}`: {error}", escaped(&place.display().to_string()))))
}

/// The studies whose reports lie below a folder, in the order of their names. Of a study that keeps some of its passes'
/// reports elsewhere only the others are taken.
fn read(folder: &Path, notes: &mut Vec<String>) -> Result<Vec<ArchivedStudy>, BatchError> {
    let mut studies = Vec::new();
    for (name, place) in folders(folder)? {
        let mut passes = Vec::new();
        for (pass_folder, place) in folders(&place)? {
            passes.extend(read_pass(pass_folder, &place, notes));
        }
        sort_by_key(&mut passes, |pass: &ArchivedPass| {
            (number(Path::new(&pass.record.pass)), pass.record.pass.clone())
        });
        if passes.iter().any(|pass| pass.record.is_archived()) {
            passes.retain(|pass| pass.record.is_archived());
        }
        if !passes.is_empty() {
            studies.push(ArchivedStudy { folder: name, passes });
        }
    }
    Ok(studies)
}

/// The report of a pass in a folder; nothing where there is none, or none with a record.
fn read_pass(folder: String, place: &Path, notes: &mut Vec<String>) -> Option<ArchivedPass> {
    let manifest = Manifest::read(place).ok()?;
    let shown = || escaped(&place.display().to_string());
    let mut leave_out = |why: &str| notes.push(format!("`{}` is not in the index: {why}", shown()));
    let Ok(bytes) = file::read(&place.join(RECORD), LARGEST) else {
        leave_out("it was rendered by an earlier version; render it again");
        return None;
    };
    if !is_listed(&manifest, &bytes) {
        leave_out("its record.json is not the one that its manifest lists; render it again");
        return None;
    }
    let manifest_file = FileRecord::of(&file::read(&place.join(MANIFEST), LARGEST).ok()?);
    match Record::read(&bytes) {
        Ok(record) => Some(ArchivedPass { folder, record, manifest, manifest_file }),
        Err(error) => {
            leave_out(&format!("its record.json cannot be read: {error}"));
            None
        }
    }
}

/// Folders in a folder by their names, links and hidden ones left out; none where it does not exist.
fn folders(folder: &Path) -> Result<BTreeMap<String, PathBuf>, BatchError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut found = BTreeMap::new();
    if !folder.is_dir() {
        return Ok(found);
    }
    let entries = std::fs::read_dir(folder).map_err(|error| {
        BatchError::job(format!("cannot list `{}`: {error}", escaped(&folder.display().to_string())))
    })?;
    for entry in entries.flatten() {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if let Some(name) = entry.file_name().to_str().filter(|name| is_folder && !name.starts_with('.')) {
            found.insert(name.to_owned(), entry.path());
        }
    }
    Ok(found)
}
