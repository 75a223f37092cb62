//! The manifest of a report: every input, job and output with its hash, the engine's version, and the command that makes
//! it again. Holds no time, host or absolute path.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::engine::Finished;
use super::error::RunnerError;
use super::key::{ENGINE_VERSION, Key};
use super::plan::Node;

/// Name of the manifest's file in a report's folder.
pub const FILE_NAME: &str = "manifest.json";
const FORMAT: &str = "bmv-manifest/1";

/// A file by its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Size.
    pub bytes: u64,
    /// Hash of the content.
    pub sha256: Key,
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
    /// The command that makes the report again, run where the inputs' paths begin.
    pub command: String,
    /// Files that were read, by their path from where the command runs.
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
    /// The report's engine version and this program's, if they differ: results of the two need not agree.
    pub other_engine: Option<(u32, u32)>,
}

impl Verification {
    /// Whether the report is as it was written: nothing changed, missing or extra. Inputs that are missing, or another
    /// version of the program, do not alter what the report says.
    pub fn is_intact(&self) -> bool {
        [&self.changed, &self.missing, &self.extra, &self.changed_inputs].iter().all(|list| list.is_empty())
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

    /// Adds an input: a file below `root`, where the command runs.
    ///
    /// # Errors
    /// [`RunnerError::File`] if it cannot be read or does not lie below `root`.
    pub fn add_input(&mut self, root: &Path, path: &Path) -> Result<(), RunnerError> {
        let (name, record) = (relative(root, path)?, hash_file(path).map_err(RunnerError::file("read", path))?);
        self.inputs.insert(name, record);
        Ok(())
    }

    /// Adds an input that was hashed already, under its path from where the command runs.
    pub fn add_input_record(&mut self, path: &str, record: FileRecord) {
        self.inputs.insert(path.to_owned(), record);
    }

    /// Adds a job with its result.
    pub fn add_job(&mut self, node: &Node, finished: &Finished) {
        let record = JobRecord {
            kind: node.task.kind().to_owned(),
            algorithm_version: node.task.algorithm_version(),
            key: finished.key.clone(),
            result_sha256: finished.stored.sha256.clone(),
        };
        self.jobs.insert(node.id.clone(), record);
    }

    /// Adds every file of a report's folder as an output, except the manifest.
    ///
    /// # Errors
    /// [`RunnerError::File`] if one cannot be read.
    pub fn add_outputs(&mut self, folder: &Path) -> Result<(), RunnerError> {
        for (name, path) in files(folder)? {
            let record = hash_file(&path).map_err(RunnerError::file("read", &path))?;
            self.outputs.insert(name, record);
        }
        Ok(())
    }

    /// Writes the manifest into a report's folder. A reader sees the old one or the new one, never a part.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses.
    pub fn write(&self, folder: &Path) -> Result<(), RunnerError> {
        let path = folder.join(FILE_NAME);
        let mut text = serde_json::to_string_pretty(self).map_err(|error| RunnerError::NotCanonical {
            what: "the manifest".to_owned(),
            reason: error.to_string(),
        })?;
        text.push('\n');
        let temporary = folder.join(format!(".{FILE_NAME}.{}", std::process::id()));
        File::create(&temporary)
            .and_then(|mut file| file.write_all(text.as_bytes()))
            .and_then(|()| fs::rename(&temporary, &path))
            .map_err(|error| {
                let _ = fs::remove_file(&temporary);
                RunnerError::file("write", &path)(error)
            })
    }

    /// Reads the manifest of a report's folder.
    ///
    /// # Errors
    /// [`RunnerError::File`] if it cannot be read, [`RunnerError::Manifest`] if it is not one, or names a path that leaves
    /// its folder.
    pub fn read(folder: &Path) -> Result<Self, RunnerError> {
        let path = folder.join(FILE_NAME);
        let text = fs::read(&path).map_err(RunnerError::file("read", &path))?;
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

    /// Recomputes every hash: outputs below the report's `folder`, inputs below `root`.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the folder cannot be listed, or a file is there and cannot be read.
    pub fn verify(&self, folder: &Path, root: &Path) -> Result<Verification, RunnerError> {
        let mut found = Verification::default();
        if self.engine_version != ENGINE_VERSION {
            found.other_engine = Some((self.engine_version, ENGINE_VERSION));
        }
        let outputs = (&self.outputs, folder, &mut found.changed, &mut found.missing);
        let inputs = (&self.inputs, root, &mut found.changed_inputs, &mut found.missing_inputs);
        for (records, base, changed, missing) in [outputs, inputs] {
            for (name, record) in records {
                let path = base.join(name);
                match hash_file(&path) {
                    Ok(now) if now == *record => found.unchanged += 1,
                    Ok(_) => changed.push(name.clone()),
                    Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                        missing.push(name.clone());
                    }
                    Err(error) => return Err(RunnerError::file("read", &path)(error)),
                }
            }
        }
        let present: BTreeSet<String> = files(folder)?.into_keys().collect();
        found.extra = present.into_iter().filter(|name| !self.outputs.contains_key(name)).collect();
        Ok(found)
    }
}

/// Size and hash of a file, read in pieces.
///
/// # Errors
/// What the system says.
pub fn hash_file(path: &Path) -> std::io::Result<FileRecord> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    let mut bytes = 0;
    loop {
        let count = file.read(&mut piece)?;
        let Some(read) = piece.get(..count).filter(|read| !read.is_empty()) else { break };
        hash.update(read);
        bytes += count as u64;
    }
    Ok(FileRecord { bytes, sha256: Key::from_digest(&hash.finalize()) })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> (tempfile::TempDir, Manifest) {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir_all(root.path().join("reports/plots")).unwrap();
        fs::write(root.path().join("model.json"), "{}").unwrap();
        fs::write(root.path().join("reports/report.md"), "# Report").unwrap();
        fs::write(root.path().join("reports/plots/a.svg"), "<svg/>").unwrap();
        let mut manifest = Manifest::new("bmv report studies/x");
        manifest.add_input(root.path(), &root.path().join("model.json")).unwrap();
        manifest.add_outputs(&root.path().join("reports")).unwrap();
        manifest.write(&root.path().join("reports")).unwrap();
        (root, manifest)
    }

    fn verify(root: &Path) -> Verification {
        let folder = root.join("reports");
        Manifest::read(&folder).unwrap().verify(&folder, root).unwrap()
    }

    #[test]
    fn a_fresh_report_is_intact() {
        let (root, manifest) = report();
        assert_eq!(Manifest::read(&root.path().join("reports")).unwrap(), manifest);
        assert_eq!(manifest.outputs.keys().collect::<Vec<_>>(), ["plots/a.svg", "report.md"]);
        let found = verify(root.path());
        assert!(found.is_intact());
        assert_eq!(found, Verification { unchanged: 3, ..Verification::default() });
    }

    #[test]
    fn changed_missing_and_extra_files_are_found() {
        let (root, _) = report();
        fs::write(root.path().join("reports/report.md"), "# Rep0rt").unwrap();
        fs::remove_file(root.path().join("reports/plots/a.svg")).unwrap();
        fs::write(root.path().join("reports/plots/b.svg"), "<svg/>").unwrap();
        fs::write(root.path().join("model.json"), "{ }").unwrap();
        let found = verify(root.path());
        assert!(!found.is_intact());
        assert_eq!(found.changed, ["report.md"]);
        assert_eq!(found.missing, ["plots/a.svg"]);
        assert_eq!(found.extra, ["plots/b.svg"]);
        assert_eq!(found.changed_inputs, ["model.json"]);
        assert_eq!(found.unchanged, 0);
    }

    #[test]
    fn missing_data_are_told_and_leave_the_report_intact() {
        let (root, _) = report();
        fs::remove_file(root.path().join("model.json")).unwrap();
        let found = verify(root.path());
        assert_eq!(found.missing_inputs, ["model.json"]);
        assert!(found.is_intact());
    }

    #[test]
    fn paths_that_leave_the_folder_are_refused() {
        let (root, mut manifest) = report();
        let folder = root.path().join("reports");
        for name in ["../model.json", "/etc/passwd", "plots/../../model.json", ""] {
            let record = FileRecord { bytes: 2, sha256: Key::of(b"{}") };
            manifest.outputs = BTreeMap::from([(name.to_owned(), record)]);
            manifest.write(&folder).unwrap();
            let error = Manifest::read(&folder).unwrap_err().to_string();
            assert!(error.contains("leaves the folder"), "{name}: {error}");
        }
        let outside = manifest.add_input(&folder, &root.path().join("model.json")).unwrap_err();
        assert!(outside.to_string().contains("it does not lie in"), "{outside}");
    }

    #[test]
    fn what_is_no_manifest_is_an_error() {
        let root = tempfile::tempdir().unwrap();
        assert!(matches!(Manifest::read(root.path()), Err(RunnerError::File { .. })));
        for text in ["", "{}", "[1", r#"{"format": "x/1"}"#] {
            fs::write(root.path().join(FILE_NAME), text).unwrap();
            assert!(matches!(Manifest::read(root.path()), Err(RunnerError::Manifest { .. })), "{text}");
        }
    }

    #[test]
    fn two_writings_give_the_same_bytes() {
        let (root, manifest) = report();
        let path = root.path().join("reports").join(FILE_NAME);
        let first = fs::read(&path).unwrap();
        manifest.write(&root.path().join("reports")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), first);
    }
}
