//! The event log: one JSON line an event, with the time, in a file a run. It is never committed and no part of a result;
//! `bmv plan` learns from it how long jobs take.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::document::visible::escaped_json;

use super::error::RunnerError;
use super::events::{Event, Listener};
use super::key::Key;
use crate::study::file;

/// Bytes that are read of a log.
const MOST_READ: u64 = 64 << 20;
/// Logs that are read for estimates, and kept at all.
pub const LOGS_KEPT: usize = 50;

#[derive(Serialize)]
struct Line<'a> {
    at_s: f64,
    event: &'a Event,
}

#[derive(Deserialize)]
struct ReadLine {
    event: Event,
}

/// Writes the events of one run.
#[derive(Debug)]
pub struct EventLog {
    path: PathBuf,
    file: Mutex<BufWriter<File>>,
}

impl EventLog {
    /// Starts a log in this folder, which is made if it is missing; the oldest logs above fifty are removed.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses.
    pub fn create(folder: &Path) -> Result<Self, RunnerError> {
        fs::create_dir_all(folder).map_err(RunnerError::file("make the folder", folder))?;
        let mut old = logs(folder);
        old.truncate(old.len().saturating_sub(LOGS_KEPT - 1));
        for path in old {
            let _ = fs::remove_file(path);
        }
        // Milliseconds in a fixed width, so that the order of the names is that of time.
        let path = folder.join(format!("{:015}-{}.jsonl", (now_s() * 1000.0) as u64, std::process::id()));
        let file = File::options()
            .append(true)
            .create_new(true)
            .open(&path)
            .map_err(RunnerError::file("write the event log", &path))?;
        Ok(Self { path, file: Mutex::new(BufWriter::new(file)) })
    }

    /// The log's file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Listener for EventLog {
    fn hear(&self, event: &Event) {
        let Ok(line) = serde_json::to_string(&Line { at_s: now_s(), event }) else { return };
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // A log that cannot be written (full disk) must not stop a run.
        let _ = writeln!(file, "{}", escaped_json(&line));
        if !matches!(event, Event::BlockDone { .. }) {
            let _ = file.flush();
        }
    }
}

/// How long jobs took, by the logs of earlier runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorkHistory {
    by_key: BTreeMap<Key, f64>,
    by_job: BTreeMap<String, f64>,
}

impl WorkHistory {
    /// Reads the logs in a folder; a folder that is missing and lines that are torn are passed over.
    pub fn read(folder: &Path) -> Self {
        let mut history = Self::default();
        for path in logs(folder) {
            let Ok((file, _)) = file::open(&path) else { continue };
            for line in BufReader::new(file.take(MOST_READ)).lines().map_while(Result::ok) {
                if !line.contains("\"job-finished\"") {
                    continue;
                }
                if let Ok(ReadLine { event: Event::JobFinished { job, key, work_s, blocks_cached: 0, .. } }) =
                    serde_json::from_str(&line)
                {
                    history.by_key.insert(key, work_s);
                    history.by_job.insert(job, work_s);
                }
            }
        }
        history
    }

    /// Whether a job of this very key ran whole.
    pub fn has(&self, key: &Key) -> bool {
        self.by_key.contains_key(key)
    }

    /// Seconds of work, on one thread, that this job took when it last ran: with this very key, or else under this id
    /// with another definition. Nothing if it never ran whole.
    pub fn work_s(&self, job: &str, key: &Key) -> Option<f64> {
        self.by_key.get(key).or_else(|| self.by_job.get(job)).copied()
    }
}

/// Paths of the logs, oldest first.
pub fn logs(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "jsonl"))
        .collect();
    paths.sort();
    paths
}

fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |elapsed| elapsed.as_secs_f64())
}
