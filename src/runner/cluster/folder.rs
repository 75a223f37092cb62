//! The folder of a run in the cache: `runs/KEY/`, with the study as it was submitted, and a folder a submission.
//!
//! ```text
//! runs/KEY/run.json            what was asked for
//!          study-N/            the files of each study, as they were read
//!          settings/           which commands may run, where the user has a list
//!          cancelled           written by `bmv cancel`
//!          driver              who follows the run: host, process, time (a hint)
//!          SUBMISSION/shards.json      which blocks each shard has
//!                     stage-N          a stage: its state, and what each block is to do
//!                     shard.sh         the script
//!                     submitted.json   the job's id
//!                     log/INDEX.out    what a shard printed
//!                     records/         how each shard ended, by itself
//! ```

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::options::Options;
use crate::document::hash::sha256;
use crate::job::Stage;
use crate::runner::cache::Cache;
use crate::runner::error::RunnerError;
use crate::runner::key::{Key, block_key};
use crate::study::file::{self, Existing};

/// Largest file of a run that is read, bytes.
const LARGEST: u64 = 1 << 30;
/// Folder of the runs in a cache.
const RUNS: &str = "runs";
/// What a submission's folder holds.
const SHARDS: &str = "shards.json";
const SUBMITTED: &str = "submitted.json";
const RECORDS: &str = "records";
/// The script of a submission.
pub(super) const SCRIPT: &str = "shard.sh";
/// What its shards print.
pub(super) const LOG: &str = "log";
const RECORD: &str = "run.json";
const CANCELLED: &str = "cancelled";
const DRIVER: &str = "driver";

/// A pass of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunPass {
    /// The pass as it was submitted, below the run's folder.
    pub file: PathBuf,
    /// Where it was read.
    pub original: PathBuf,
}

/// What was asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunRecord {
    /// The scheduler.
    pub engine: String,
    /// Its passes.
    pub passes: Vec<RunPass>,
    /// Ids of the wanted jobs, with the passes where they were read.
    pub jobs: Vec<String>,
    /// How the cluster is used.
    pub options: Options,
    /// Whether all commands that models name may run.
    pub allow_commands: bool,
    /// Whether servers of other machines may be asked.
    pub allow_remote_models: bool,
}

/// The folder of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFolder {
    /// The folder of the cache, from the root of the file system.
    pub cache: PathBuf,
    /// The run: the hash of the keys of the jobs that it is to give.
    pub key: Key,
}

impl RunFolder {
    /// The folder of the run that gives the jobs of these keys.
    ///
    /// # Errors
    /// A cache whose path the system does not know, or a scheduler would misread.
    pub fn new(cache: &Cache, keys: &[&Key]) -> Result<Self, RunnerError> {
        let mut names: Vec<&str> = keys.iter().map(|key| key.as_str()).collect();
        names.sort_unstable();
        let path = std::path::absolute(cache.root()).map_err(RunnerError::file("find", cache.root()))?;
        let shown = path.display().to_string();
        if let Some(wrong) = shown.chars().find(|c| matches!(c, '%' | '\\' | '\'' | ',') || c.is_control()) {
            return Err(RunnerError::Submission {
                reason: format!(
                    "the path of the cache, `{}`, has the character {wrong:?}, which a scheduler reads otherwise: name another one by --cache",
                    shown.escape_debug()
                ),
            });
        }
        Ok(Self { cache: path, key: Key::of(names.join("\n").as_bytes()) })
    }

    /// The run of this key, or of the only one that begins so.
    ///
    /// # Errors
    /// None, or several.
    pub fn find(cache: &Cache, beginning: &str) -> Result<Self, RunnerError> {
        let path = std::path::absolute(cache.root()).map_err(RunnerError::file("find", cache.root()))?;
        let keys = Self::all(&path);
        let matching: Vec<&Key> = keys.iter().filter(|key| key.as_str().starts_with(beginning)).collect();
        match matching[..] {
            [key] => Ok(Self { cache: path, key: key.clone() }),
            [] => {
                let there: Vec<&str> = keys.iter().map(Key::short).collect();
                let there = if there.is_empty() {
                    "there are none".to_owned()
                } else {
                    format!("there are {}", there.join(", "))
                };
                Err(RunnerError::Submission {
                    reason: format!("no run `{beginning}` in the cache `{}`: {there}", path.display()),
                })
            }
            _ => Err(RunnerError::Submission {
                reason: format!("several runs begin with `{beginning}`: give more of the key"),
            }),
        }
    }

    /// The keys of all runs of a cache.
    pub fn all(cache: &Path) -> Vec<Key> {
        let entries = fs::read_dir(cache.join(RUNS)).into_iter().flatten().flatten();
        let mut keys: Vec<Key> =
            entries.filter_map(|entry| Key::try_from(entry.file_name().into_string().ok()?).ok()).collect();
        keys.sort();
        keys
    }

    /// Its path.
    pub fn path(&self) -> PathBuf {
        self.cache.join(self.inside())
    }

    fn inside(&self) -> PathBuf {
        Path::new(RUNS).join(self.key.as_str())
    }

    /// The name of its jobs.
    pub fn name(&self) -> String {
        format!("bmv-{}", self.key.short())
    }

    /// By which a submission is known again.
    pub fn comment(&self, submission: u32) -> String {
        format!("bmv:{}:{submission}", self.key)
    }

    /// Writes a file of the run.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, relative: &Path, bytes: &[u8]) -> Result<(), RunnerError> {
        let inside = self.inside().join(relative);
        file::write(&self.cache, &inside, bytes, Existing::Replace)
            .map_err(RunnerError::file("write", self.cache.join(&inside)))
    }

    fn write_json(&self, relative: &Path, value: &impl Serialize) -> Result<(), RunnerError> {
        let bytes = serde_json::to_vec(value).map_err(|error| RunnerError::NotCanonical {
            what: relative.display().to_string(),
            reason: error.to_string(),
        })?;
        self.write(relative, &bytes)
    }

    /// Writes down what was asked for.
    ///
    /// # Errors
    /// What the system says.
    pub fn write_record(&self, record: &RunRecord) -> Result<(), RunnerError> {
        self.write_json(Path::new(RECORD), record)
    }

    /// What was asked for.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn record(&self) -> Result<RunRecord, RunnerError> {
        read_json(&self.path().join(RECORD))
    }

    /// Its submissions, in order.
    pub fn submissions(&self) -> Vec<Submission> {
        let entries = fs::read_dir(self.path()).into_iter().flatten().flatten();
        let mut numbers: Vec<u32> = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect();
        numbers.sort_unstable();
        numbers.into_iter().map(|number| Submission { run: self.clone(), number }).collect()
    }

    /// Whether `bmv cancel` ended it.
    pub fn is_cancelled(&self) -> bool {
        self.path().join(CANCELLED).exists()
    }

    /// Notes that it was ended, or that it goes on.
    ///
    /// # Errors
    /// What the system says.
    pub fn set_cancelled(&self, is_cancelled: bool) -> Result<(), RunnerError> {
        if is_cancelled {
            return self.write(Path::new(CANCELLED), b"");
        }
        match fs::remove_file(self.path().join(CANCELLED)) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(RunnerError::file("remove", self.path().join(CANCELLED))(error))
            }
            _ => Ok(()),
        }
    }

    /// Notes that this process follows the run; gives who does so already, on this machine and alive.
    pub fn follow(&self) -> (Followed, Option<String>) {
        let path = self.path().join(DRIVER);
        let host = crate::runner::cache::host();
        let before = file::read(&path, 1 << 10).ok().and_then(|bytes| String::from_utf8(bytes).ok());
        let other = before.filter(|text| {
            let mut words = text.split_whitespace();
            let is_here = words.next() == Some(host.as_str());
            words.next().is_some_and(|process| !is_here || Path::new("/proc").join(process).exists())
        });
        let own = format!("{host} {} {}", std::process::id(), seconds_since_1970());
        // A hint, nothing more: two that follow one run are only wasteful.
        let _ = self.write(Path::new(DRIVER), own.as_bytes());
        (Followed { path, own }, other)
    }
}

/// That this process follows a run; dropped, it no longer does.
#[derive(Debug)]
pub struct Followed {
    path: PathBuf,
    own: String,
}

impl Drop for Followed {
    fn drop(&mut self) {
        if file::read(&self.path, 1 << 10).is_ok_and(|bytes| bytes == self.own.as_bytes()) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// A stage as shards read it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct StageRecord {
    /// Its file in the submission's folder.
    pub file: String,
    /// SHA-256 of that file.
    pub sha256: Key,
    /// The pass, below the run's folder.
    pub pass: PathBuf,
    /// Key of the job.
    pub owner: Key,
    /// Number of its blocks.
    pub blocks: usize,
}

/// Blocks of a stage that follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Range {
    /// Place of the stage among those of the submission.
    pub stage: usize,
    /// The first block.
    pub first: usize,
    /// How many.
    pub count: usize,
}

/// What a task is to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ShardRecord {
    /// How often its blocks were submitted, this time counted.
    pub attempt: u32,
    /// Its blocks.
    pub blocks: Vec<Range>,
}

/// What the tasks of an array are to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ShardList {
    /// Stages.
    pub stages: Vec<StageRecord>,
    /// Shards by the index of the task.
    pub shards: Vec<ShardRecord>,
}

/// That a submission was accepted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Submitted {
    /// The job's id.
    pub job: String,
    /// Its name.
    pub name: String,
    /// Its comment.
    pub comment: String,
    /// When, seconds since 1970.
    pub at_s: u64,
}

/// How a shard ended, in its own words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// Its index in the array.
    pub index: usize,
    /// Name of the machine.
    pub host: String,
    /// Name of the machine for the scheduler.
    pub node: Option<String>,
    /// How often the scheduler started it again.
    pub restart: u64,
    /// When it began, seconds since 1970.
    pub started_s: f64,
    /// When it ended.
    pub ended_s: f64,
    /// SHA-256 of the program.
    pub program_sha256: String,
    /// Blocks that it ran.
    pub blocks_run: usize,
    /// Blocks that were there.
    pub blocks_found: usize,
    /// Exit status.
    pub code: u8,
    /// Why it published less than it had to.
    pub error: Option<String>,
    /// Blocks that failed and would fail again.
    pub failures: Vec<Failure>,
}

/// A block that has no result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Failure {
    /// Name of its output in the cache.
    pub block: Key,
    /// Its place in the stage.
    pub index: usize,
    /// Why.
    pub reason: String,
}

/// What heads a stage's file: its name, and how long what follows is: the state, then what each block is to do.
#[derive(Serialize, Deserialize)]
struct StageHead {
    name: String,
    state: usize,
    inputs: Vec<usize>,
}

/// A stage as it was written down.
pub(super) struct WrittenStage {
    /// Its name.
    pub name: String,
    /// Its state.
    pub state: Vec<u8>,
    /// SHA-256 of that, which is part of every block's name.
    state_sha256: [u8; 32],
    /// What each block is to do.
    pub inputs: Vec<Vec<u8>>,
}

impl WrittenStage {
    /// The name of a block's output in the cache.
    pub fn block(&self, owner: &Key, index: usize) -> Option<Key> {
        Some(block_key(owner, &self.name, index, [self.state_sha256, sha256(self.inputs.get(index)?)]))
    }
}

/// A submission of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submission {
    /// Its run.
    pub run: RunFolder,
    /// Its number, from 1.
    pub number: u32,
}

impl Submission {
    /// The submission in a folder.
    ///
    /// # Errors
    /// A folder that is none.
    pub fn at(folder: &Path) -> Result<Self, RunnerError> {
        let wrong = || RunnerError::Submission {
            reason: format!("`{}` is no submission of a run: runs/KEY/NUMBER of a cache is", folder.display()),
        };
        let name = |path: &Path| path.file_name().and_then(|name| name.to_str()).map(str::to_owned);
        let number = name(folder).and_then(|name| name.parse().ok()).ok_or_else(wrong)?;
        let run = folder.parent().ok_or_else(wrong)?;
        let key = name(run).and_then(|name| Key::try_from(name).ok()).ok_or_else(wrong)?;
        let cache = run.parent().and_then(Path::parent).ok_or_else(wrong)?.to_owned();
        Ok(Self { run: RunFolder { cache, key }, number })
    }

    /// Its path.
    pub fn path(&self) -> PathBuf {
        self.run.path().join(self.number.to_string())
    }

    fn inside(&self, name: &str) -> PathBuf {
        Path::new(&self.number.to_string()).join(name)
    }

    /// Makes its folders, which must be there before a task runs.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn make_folders(&self) -> Result<(), RunnerError> {
        for name in [LOG, RECORDS] {
            let inside = self.run.inside().join(self.inside(name));
            file::make_folder(&self.run.cache, &inside)
                .map_err(RunnerError::file("make the folder", self.run.cache.join(&inside)))?;
        }
        Ok(())
    }

    /// Writes a stage, and gives how shards find it.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write_stage(
        &self,
        number: usize,
        stage: &Stage,
        pass: &Path,
        owner: &Key,
    ) -> Result<StageRecord, RunnerError> {
        let head = StageHead {
            name: stage.name.clone(),
            state: stage.state.bytes().len(),
            inputs: stage.inputs.iter().map(Vec::len).collect(),
        };
        let mut bytes = Vec::new();
        ciborium::into_writer(&head, &mut bytes).map_err(|error| RunnerError::NotCanonical {
            what: format!("the stage `{}`", stage.name),
            reason: error.to_string(),
        })?;
        bytes.extend_from_slice(stage.state.bytes());
        stage.inputs.iter().for_each(|input| bytes.extend_from_slice(input));
        let file = format!("stage-{number}");
        self.run.write(&self.inside(&file), &bytes)?;
        let (pass, owner) = (pass.to_owned(), owner.clone());
        Ok(StageRecord { file, sha256: Key::of(&bytes), pass, owner, blocks: stage.inputs.len() })
    }

    /// Reads a stage, as it was written.
    ///
    /// # Errors
    /// It cannot be read, or is another one.
    pub(super) fn stage(&self, record: &StageRecord) -> Result<WrittenStage, RunnerError> {
        let path = self.path().join(&record.file);
        let bytes = file::read(&path, LARGEST).map_err(RunnerError::file("read", &path))?;
        let damaged =
            |reason: String| RunnerError::file("read", &path)(std::io::Error::new(ErrorKind::InvalidData, reason));
        if Key::of(&bytes) != record.sha256 {
            return Err(damaged("it is not what was written".to_owned()));
        }
        let mut rest = bytes.as_slice();
        let head: StageHead = ciborium::from_reader(&mut rest).map_err(|error| damaged(error.to_string()))?;
        let mut take = |length: usize| {
            let (first, left) = rest.split_at_checked(length)?;
            rest = left;
            Some(first.to_vec())
        };
        let state = take(head.state);
        let inputs: Option<Vec<Vec<u8>>> = head.inputs.into_iter().map(take).collect();
        match (state, inputs) {
            (Some(state), Some(inputs)) => {
                Ok(WrittenStage { name: head.name, state_sha256: sha256(&state), state, inputs })
            }
            _ => Err(damaged("it is cut off".to_owned())),
        }
    }

    /// Writes which shards there are.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write_shards(&self, shards: &ShardList) -> Result<(), RunnerError> {
        self.run.write_json(&self.inside(SHARDS), shards)
    }

    /// Which shards there are.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn shards(&self) -> Result<ShardList, RunnerError> {
        read_json(&self.path().join(SHARDS))
    }

    /// Writes a script, and gives its path.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write_script(&self, name: &str, text: &str) -> Result<PathBuf, RunnerError> {
        self.run.write(&self.inside(name), text.as_bytes())?;
        Ok(self.path().join(name))
    }

    /// Notes that it was accepted.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn set_submitted(&self, job: &str) -> Result<(), RunnerError> {
        let (name, comment) = (self.run.name(), self.run.comment(self.number));
        self.run.write_json(
            &self.inside(SUBMITTED),
            &Submitted { job: job.to_owned(), name, comment, at_s: seconds_since_1970() },
        )
    }

    /// The job's id, if it was accepted and that could be noted.
    pub fn job(&self) -> Option<String> {
        let submitted: Submitted = read_json(&self.path().join(SUBMITTED)).ok()?;
        Some(submitted.job)
    }

    /// Writes how a shard ended, under a name of its own.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write_record(&self, record: &Record) -> Result<(), RunnerError> {
        let name = format!("{}-{}-{}-{}.json", record.index, record.restart, record.host, std::process::id());
        self.run.write_json(&self.inside(RECORDS).join(name), record)
    }

    /// Names of the records that are there.
    pub(super) fn record_names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path().join(RECORDS)).into_iter().flatten().flatten();
        entries
            .filter_map(|entry| entry.file_name().into_string().ok())
            .filter(|name| name.ends_with(".json"))
            .collect()
    }

    /// A record.
    pub(super) fn record(&self, name: &str) -> Option<Record> {
        read_json(&self.path().join(RECORDS).join(name)).ok()
    }
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, RunnerError> {
    let bytes = file::read(path, LARGEST).map_err(RunnerError::file("read", path))?;
    let damaged = |error: serde_json::Error| std::io::Error::new(ErrorKind::InvalidData, error.to_string());
    serde_json::from_slice(&bytes).map_err(|error| RunnerError::file("read", path)(damaged(error)))
}

/// Now, seconds since 1970.
pub(super) fn seconds_since_1970() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs())
}
