//! Batches on a cluster: the studies as they were submitted, and what was asked of them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::inputs::read_files;
use super::load::{LoadedPass, load};
use super::prepared::Prepared;
use super::{BatchError, Loaded, Reading, prepare};
use crate::runner::cluster::{Options, RunFolder, RunPass, RunRecord};
use crate::runner::external::Access;
use crate::runner::{Cache, Key, Plan, RunnerError};
use crate::study::document::FILE as DOCUMENT;
use crate::study::project::whole;
use crate::study::{Content, file};

/// Largest file of a study, bytes.
const LARGEST: u64 = 1 << 30;

/// Writes down what is to run: the studies' files, as they were read, and what was asked for. A run of the same jobs has the
/// same folder.
///
/// # Errors
/// A file that changed since it was read; a cache that cannot be written.
pub fn submit(
    prepared: &Prepared,
    cache: &Cache,
    engine: &str,
    options: Options,
    access: &Access,
) -> Result<(RunFolder, RunRecord), BatchError> {
    let keys = prepared.wanted_keys();
    let folder = RunFolder::new(cache, &keys)?;
    let mut studies: Vec<&Path> = Vec::new();
    let mut passes = Vec::new();
    for pass in prepared.passes() {
        let number = studies.iter().position(|study| *study == pass.study).unwrap_or_else(|| {
            studies.push(&pass.study);
            studies.len() - 1
        });
        let study = PathBuf::from(format!("study-{number}"));
        copy(pass, &folder, &study)?;
        passes.push(RunPass { file: study.join(&pass.file), original: whole(&pass.study).join(&pass.file) });
    }
    if let Some(list) = access.list() {
        folder.write(Path::new("settings/bmv/allowed-commands"), &list)?;
    }
    let jobs = prepared.wanted_jobs();
    let (allow_commands, allow_remote_models) = access.flags();
    let record = RunRecord { engine: engine.to_owned(), passes, jobs, options, allow_commands, allow_remote_models };
    folder.write_record(&record)?;
    folder.set_cancelled(false)?;
    Ok((folder, record))
}

/// Copies what was read of a study for a pass.
fn copy(pass: &LoadedPass, folder: &RunFolder, study: &Path) -> Result<(), BatchError> {
    let files: BTreeMap<String, Content> = read_files(&pass.pass).map_err(BatchError::input)?;
    // The document that reports belong to decides no job, and may name passes that are not among these.
    for (name, content) in files.into_iter().filter(|(name, _)| name != DOCUMENT) {
        let path = pass.study.join(&name);
        let bytes = file::read(&path, LARGEST).map_err(RunnerError::file("read", &path))?;
        if Content::of(&bytes) != content {
            return Err(BatchError::input(format!("`{name}` changed while the study was read: run the command again")));
        }
        let inside = study.join(&name);
        // An earlier submission's shards may read it.
        if file::read(&folder.path().join(&inside), LARGEST).is_ok_and(|there| there == bytes) {
            continue;
        }
        folder.write(&inside, &bytes)?;
        let permissions = fs::metadata(&path).map_err(RunnerError::file("read", &path))?.permissions();
        let copied = folder.path().join(&inside);
        fs::set_permissions(&copied, permissions).map_err(RunnerError::file("write", &copied))?;
    }
    Ok(())
}

/// What a run is to give, prepared from the studies where they were read if they still ask for the same, else from them as
/// they were submitted; whether they do.
///
/// # Errors
/// What cannot be read.
pub fn resume(folder: &RunFolder, record: &RunRecord, reading: &Reading) -> Result<(Prepared, bool), BatchError> {
    let of = |paths: Vec<PathBuf>, jobs: &BTreeSet<String>| -> Result<Prepared, BatchError> {
        let loaded = load(&paths, reading)?;
        prepare(loaded, Loaded::default(), |pass, _, name| jobs.contains(&job_name(&pass.file, name)))
    };
    let jobs: BTreeSet<String> = record.jobs.iter().cloned().collect();
    let is_same = |prepared: &Prepared| {
        let mut keys: Vec<&str> = prepared.wanted_keys().iter().map(|key| key.as_str()).collect();
        keys.sort_unstable();
        Key::of(keys.join("\n").as_bytes()) == folder.key
    };
    let originals = record.passes.iter().map(|pass| pass.original.clone()).collect();
    if let Ok(prepared) = of(originals, &jobs)
        && is_same(&prepared)
    {
        return Ok((prepared, true));
    }
    let copies = record.passes.iter().map(|pass| folder.path().join(&pass.file)).collect();
    let prepared = of(copies, &jobs)?;
    if is_same(&prepared) {
        return Ok((prepared, false));
    }
    Err(BatchError::input(format!(
        "run {} was submitted by another version of the program: `bmv run` begins anew",
        folder.key.short()
    )))
}

/// The jobs of one pass of a run, for a shard.
///
/// # Errors
/// What cannot be read.
pub fn plan_of(pass: &Path, reading: &Reading) -> Result<Plan, BatchError> {
    Ok(Plan::new(load(&[pass.to_owned()], reading)?.nodes)?)
}

/// A job of a run by its pass's file and its name.
pub(super) fn job_name(file: &str, name: &str) -> String {
    format!("{file}:{name}")
}

/// The pass of each job of a run, as it was submitted.
pub fn passes_of(prepared: &Prepared, folder: &RunFolder, record: &RunRecord) -> BTreeMap<Key, PathBuf> {
    let mut passes = BTreeMap::new();
    let run = whole(&folder.path());
    for pass in prepared.passes() {
        let place = whole(&pass.study).join(&pass.file);
        let is_it = |submitted: &&RunPass| submitted.original == place || run.join(&submitted.file) == place;
        let Some(submitted) = record.passes.iter().find(is_it) else { continue };
        for key in prepared.keys_for(pass) {
            passes.entry(key).or_insert_with(|| submitted.file.clone());
        }
    }
    passes
}
