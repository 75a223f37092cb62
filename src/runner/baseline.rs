//! Baselines: of every job of a study the hash of its result and its key numbers, in `baseline/PASS/JOB.json`, against which
//! later runs are held.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::RunnerError;
use super::key::Key;
use crate::job::key_number::KeyNumber;
use crate::study::file::{self, Existing};

/// The form of the files.
const FORMAT: &str = "bmv-baseline/1";
/// Largest baseline that is read, bytes.
const LARGEST: u64 = 1 << 26;

/// What a job's result was, and why it was taken for the baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// The form of the file.
    format: String,
    /// Why it was last renewed.
    pub because: String,
    /// When, as whoever renewed it wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Version of the program.
    pub program: String,
    /// Kind of the job.
    pub kind: String,
    /// Version of that kind's algorithm.
    pub algorithm_version: u32,
    /// Version of the numeric engine.
    pub engine_version: u32,
    /// Seed.
    pub seed: u64,
    /// Key of the job: what decided the result.
    pub key: Key,
    /// SHA-256 of the canonical bytes of the result.
    pub sha256: Key,
    /// Key numbers.
    pub numbers: Vec<KeyNumber>,
}

impl Baseline {
    /// A baseline of a result; `because` and `date` are written down.
    pub fn new(
        because: &str,
        date: Option<&str>,
        (kind, algorithm_version, engine_version): (&str, u32, u32),
        (seed, key): (u64, &Key),
        sha256: &Key,
        numbers: Vec<KeyNumber>,
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            because: because.to_owned(),
            date: date.map(str::to_owned),
            program: env!("CARGO_PKG_VERSION").to_owned(),
            kind: kind.to_owned(),
            algorithm_version,
            engine_version,
            seed,
            key: key.clone(),
            sha256: sha256.clone(),
            numbers,
        }
    }

    /// Whether it is of the same result by the same definition, whatever the reason and the program that wrote it.
    pub fn is_of_same(&self, other: &Self) -> bool {
        (&self.key, &self.sha256, &self.numbers) == (&other.key, &other.sha256, &other.numbers)
    }

    /// Reads the baseline at a path. Nothing if none is there.
    ///
    /// # Errors
    /// [`RunnerError::File`] if it cannot be read, [`RunnerError::Baseline`] if it is none.
    pub fn read(path: &Path) -> Result<Option<Self>, RunnerError> {
        let text = match file::read(path, LARGEST) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read.map_err(RunnerError::file("read", path))?,
        };
        let damaged = |reason: String| RunnerError::Baseline { path: path.to_owned(), reason };
        let baseline: Self = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
        if baseline.format != FORMAT {
            return Err(damaged(format!("its format is `{}`, this version reads `{FORMAT}`", baseline.format)));
        }
        let is_wrong = |number: &&KeyNumber| {
            let error = number.error.is_some_and(|error| {
                !(error.standard_error >= 0.0) || error.degrees_of_freedom.is_some_and(|degrees| !(degrees > 0.0))
            });
            error || !number.value.is_finite()
        };
        match baseline.numbers.iter().find(is_wrong) {
            Some(number) => Err(damaged(format!("`{}` has no possible error", number.name()))),
            None => Ok(Some(baseline)),
        }
    }

    /// Writes it to its path in the study's folder: the facts on a line each, and a line a number, so that versions can be
    /// compared line by line.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses, or a link is in the way.
    pub fn write(&self, study: &Path, path: &Path) -> Result<(), RunnerError> {
        let not_json = |error: serde_json::Error| RunnerError::NotCanonical {
            what: format!("the baseline `{}`", path.display()),
            reason: error.to_string(),
        };
        let facts = serde_json::to_string_pretty(&Self { numbers: Vec::new(), ..self.clone() }).map_err(not_json)?;
        let lines = self.numbers.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>().map_err(not_json)?;
        let numbers = if lines.is_empty() { "[]".to_owned() } else { format!("[\n    {}\n  ]", lines.join(",\n    ")) };
        let head = facts.strip_suffix("[]\n}").unwrap_or(&facts);
        let text = format!("{head}{numbers}\n}}\n");
        file::write(study, path, text.as_bytes(), Existing::Replace)
            .map_err(RunnerError::file("write", study.join(path)))
    }
}

/// Where a job's baseline lies in the study's folder: names of jobs may hold any character, so those that file systems treat
/// in their own way are written as `%` and their code.
pub fn path(pass: &str, job: &str) -> PathBuf {
    folder(pass).join(format!("{}.json", file_name(job)))
}

/// Where the baselines of a pass lie in the study's folder.
pub fn folder(pass: &str) -> PathBuf {
    Path::new("baseline").join(file_name(pass.strip_suffix(".json").unwrap_or(pass)))
}

/// The files in the folder of a pass's baselines, in the order of their names; none where there is no such folder.
///
/// # Errors
/// [`RunnerError::File`] if the system refuses.
pub fn files(study: &Path, pass: &str) -> Result<Vec<PathBuf>, RunnerError> {
    let folder = study.join(self::folder(pass));
    let entries = match std::fs::read_dir(&folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        read => read.map_err(RunnerError::file("read", &folder))?,
    };
    let mut files = Vec::new();
    for entry in entries {
        files.push(entry.map_err(RunnerError::file("read", &folder))?.path());
    }
    files.sort();
    Ok(files)
}

fn file_name(name: &str) -> String {
    let mut out = String::new();
    for (position, character) in name.chars().enumerate() {
        let is_plain = character.is_alphanumeric() || matches!(character, '-' | '_' | ' ' | '+');
        if is_plain || (character == '.' && position > 0) {
            out.push(character);
        } else {
            out.push_str(&format!("%{:02X}", u32::from(character)));
        }
    }
    out
}
