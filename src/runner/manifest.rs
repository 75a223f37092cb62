//! The manifest of a report: every input, job and output with its hash, the engine's version, and the command that makes
//! it again. Holds no time, host or absolute path.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::engine::Finished;
use super::error::RunnerError;
use super::key::{ENGINE_VERSION, Key, canonical_bytes};
use super::plan::Node;
use crate::study::file::{self, Existing};

/// Name of the manifest's file in a report's folder.
pub const FILE_NAME: &str = "manifest.json";
const FORMAT: &str = "bmv-manifest/1";
/// Largest manifest that is read, bytes: some hundred thousand files.
const LARGEST: u64 = 64 << 20;

/// A file by its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Size.
    pub bytes: u64,
    /// Hash of the content.
    pub sha256: Key,
}

impl FileRecord {
    /// The record of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, sha256: Key::of(bytes) }
    }
}

/// A job by its key and result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobRecord {
    /// Kind.
    pub kind: String,
    /// Version of that kind's algorithm.
    pub algorithm_version: u32,
    /// Key.
    pub key: Key,
    /// SHA-256 of the result in canonical form.
    pub result_sha256: Key,
}

/// What a report was made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// `bmv-manifest/1`.
    pub format: String,
    /// Version of the numeric engine.
    pub engine_version: u32,
    /// The command that makes the report again, run in the project's folder.
    pub command: String,
    /// Files that were read, as they were then, by their path from the project's folder.
    pub inputs: BTreeMap<String, FileRecord>,
    /// Jobs, by id.
    pub jobs: BTreeMap<String, JobRecord>,
    /// Files that were written, by their path from the report's folder.
    pub outputs: BTreeMap<String, FileRecord>,
}

/// What differs between a manifest and the files. Paths of inputs and outputs as the manifest has them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verification {
    /// Files that are as listed.
    pub unchanged: usize,
    /// Outputs with another content.
    pub changed: Vec<String>,
    /// Outputs that are not there.
    pub missing: Vec<String>,
    /// Files in the report's folder that the manifest does not list.
    pub extra: Vec<String>,
    /// Inputs with another content.
    pub changed_inputs: Vec<String>,
    /// Inputs that are not there (data that may not lie in the repository often are not).
    pub missing_inputs: Vec<String>,
    /// What the report's own files say against one another or against the manifest.
    pub contradictions: Vec<String>,
    /// The report's engine version and this program's, if they differ: results of the two need not agree.
    pub other_engine: Option<(u32, u32)>,
}

impl Verification {
    /// Whether the report is as it was written: nothing changed, missing, extra or contradictory. Inputs that are
    /// missing, or another version of the program, do not alter what the report says.
    pub fn is_intact(&self) -> bool {
        let lists = [&self.changed, &self.missing, &self.extra, &self.changed_inputs, &self.contradictions];
        lists.iter().all(|list| list.is_empty())
    }
}

impl Manifest {
    /// A manifest without files or jobs.
    pub fn new(command: impl Into<String>) -> Self {
        Self {
            format: FORMAT.to_owned(),
            engine_version: ENGINE_VERSION,
            command: command.into(),
            inputs: BTreeMap::new(),
            jobs: BTreeMap::new(),
            outputs: BTreeMap::new(),
        }
    }

    /// Adds an input, under its path from the project's folder: what was read of it, not what lies there now.
    pub fn add_input(&mut self, path: impl Into<String>, record: FileRecord) {
        self.inputs.insert(path.into(), record);
    }

    /// Adds a job with its result.
    pub fn add_job(&mut self, id: impl Into<String>, node: &Node, finished: &Finished) {
        let record = JobRecord {
            kind: node.task.kind().to_owned(),
            algorithm_version: node.task.algorithm_version(),
            key: finished.key.clone(),
            result_sha256: finished.stored.sha256.clone(),
        };
        self.jobs.insert(id.into(), record);
    }

    /// Adds an output, under its path from the report's folder.
    pub fn add_output(&mut self, path: impl Into<String>, bytes: &[u8]) {
        self.outputs.insert(path.into(), FileRecord::of(bytes));
    }

    /// SHA-256 of everything but the outputs, in canonical form: what a report says of where it comes from.
    ///
    /// # Errors
    /// [`RunnerError::NotCanonical`] if it has no canonical form.
    pub fn origin_sha256(&self) -> Result<Key, RunnerError> {
        let origin = Self { outputs: BTreeMap::new(), ..self.clone() };
        let value = serde_json::to_value(origin).map_err(not_canonical)?;
        Ok(Key::of(&canonical_bytes(&value, WHAT)?))
    }

    /// The text of its file.
    ///
    /// # Errors
    /// [`RunnerError::NotCanonical`] if JSON cannot hold it.
    pub fn text(&self) -> Result<String, RunnerError> {
        Ok(serde_json::to_string_pretty(self).map_err(not_canonical)? + "\n")
    }

    /// Writes the manifest into a report's folder, `relative` below `base`. A reader sees the old one or the new one,
    /// never a part.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses, or a link is in the way.
    pub fn write(&self, base: &Path, relative: &Path) -> Result<(), RunnerError> {
        let place = relative.join(FILE_NAME);
        file::write(base, &place, self.text()?.as_bytes(), Existing::Replace)
            .map_err(RunnerError::file("write", base.join(&place)))
    }

    /// Reads the manifest of a report's folder.
    ///
    /// # Errors
    /// [`RunnerError::File`] if it cannot be read, [`RunnerError::Manifest`] if it is not one, or names a path that leaves
    /// its folder.
    pub fn read(folder: &Path) -> Result<Self, RunnerError> {
        let path = folder.join(FILE_NAME);
        let text = file::read(&path, LARGEST).map_err(RunnerError::file("read", &path))?;
        let refuse = |reason: String| RunnerError::Manifest { path: path.clone(), reason };
        let manifest: Self = serde_json::from_slice(&text).map_err(|error| refuse(error.to_string()))?;
        if manifest.format != FORMAT {
            return Err(refuse(format!("its format is `{}`, expected `{FORMAT}`", manifest.format)));
        }
        match manifest.inputs.keys().chain(manifest.outputs.keys()).find(|name| !is_inside(name)) {
            Some(name) => Err(refuse(format!("the path `{name}` leaves the folder"))),
            None => Ok(manifest),
        }
    }

    /// Recomputes every hash: outputs below the report's `folder`, inputs below the project's folder `root`. What is no
    /// regular file has changed; of inputs, links are followed as they are when a study is read.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the folder cannot be listed, or a file is there and cannot be read.
    pub fn verify(&self, folder: &Path, root: &Path) -> Result<Verification, RunnerError> {
        let mut verification = Verification::default();
        if self.engine_version != ENGINE_VERSION {
            verification.other_engine = Some((self.engine_version, ENGINE_VERSION));
        }
        let outputs = (&self.outputs, folder, false, &mut verification.changed, &mut verification.missing);
        let inputs = (&self.inputs, root, true, &mut verification.changed_inputs, &mut verification.missing_inputs);
        for (records, base, follows, changed, missing) in [outputs, inputs] {
            for (name, record) in records {
                let path = base.join(name);
                match is_as_recorded(&path, record, follows) {
                    Ok(true) => verification.unchanged += 1,
                    Ok(false) => changed.push(name.clone()),
                    Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                        missing.push(name.clone());
                    }
                    Err(error) => return Err(RunnerError::file("read", &path)(error)),
                }
            }
        }
        let present: BTreeSet<String> = files(folder)?.into_keys().collect();
        verification.extra = present.into_iter().filter(|name| !self.outputs.contains_key(name)).collect();
        Ok(verification)
    }
}

/// What is written, in messages.
const WHAT: &str = "the manifest";

fn not_canonical(error: serde_json::Error) -> RunnerError {
    RunnerError::NotCanonical { what: WHAT.to_owned(), reason: error.to_string() }
}

/// Whether a file is a regular one with this content, read in pieces; of another size nothing is read.
fn is_as_recorded(path: &Path, record: &FileRecord, follows: bool) -> std::io::Result<bool> {
    let opened = if follows { path.canonicalize().and_then(|path| file::open(&path)) } else { file::open(path) };
    let (file, length) = match opened {
        Err(error) if error.kind() == ErrorKind::InvalidData => return Ok(false),
        opened => opened?,
    };
    if length != record.bytes {
        return Ok(false);
    }
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    // It may grow while it is read.
    let mut file = file.take(length);
    loop {
        let count = file.read(&mut piece)?;
        let Some(read) = piece.get(..count).filter(|read| !read.is_empty()) else { break };
        hash.update(read);
    }
    Ok(Key::from_digest(&hash.finalize()) == record.sha256)
}

/// Whether a path of a manifest stays below its folder.
fn is_inside(name: &str) -> bool {
    !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}

/// A path from `root`, with `/`.
fn relative(root: &Path, path: &Path) -> Result<String, RunnerError> {
    let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().into_owned();
    if is_inside(&name) {
        return Ok(name);
    }
    let reason = std::io::Error::new(ErrorKind::InvalidInput, format!("it does not lie in `{}`", root.display()));
    Err(RunnerError::file("list in the manifest", path)(reason))
}

/// All files below a report's folder by their path from it, without the manifest itself.
fn files(folder: &Path) -> Result<BTreeMap<String, PathBuf>, RunnerError> {
    let mut files = BTreeMap::new();
    for entry in walkdir::WalkDir::new(folder) {
        let entry = entry.map_err(|error| RunnerError::file("list", folder)(error.into()))?;
        if entry.file_type().is_dir() {
            continue;
        }
        let name = relative(folder, entry.path())?;
        if name != FILE_NAME {
            files.insert(name, entry.into_path());
        }
    }
    Ok(files)
}
