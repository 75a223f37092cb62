//! Where the verbs meet the rooms that load studies and render reports.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::execute::Executed;
use super::output::escaped;
use super::status::Failure;
use crate::job::{Job, JobError, compare, propagate};
use crate::report::assemble::{FinishedJob, Surroundings, assemble};
use crate::report::{self, FileHash, JobEntry, JobResult, PassReport};
use crate::runner::manifest::Manifest;
use crate::runner::{ENGINE_VERSION, Node, Ready, Task};
use crate::study::pinned::{self, Obtained, State};
use crate::study::ready::{Deferred, Readiness};
use crate::study::{Folder, Pass, discover};

/// Diagnostics printed of one file.
const MOST_DIAGNOSTICS: usize = 50;

/// A pass that was asked for.
#[derive(Clone, Debug)]
pub struct LoadedPass {
    /// Path of the pass file, as people see it.
    pub shown: String,
    /// Folder of the study.
    pub study: PathBuf,
    /// Name of the pass file in it.
    pub file: String,
    /// Ids of its jobs, in the order of the file.
    pub jobs: Vec<String>,
    /// Jobs that do not run now, each with its reason.
    pub not_run: Vec<String>,
    /// The pass.
    pub pass: Arc<Pass>,
}

/// Passes with their jobs, ready to plan.
#[derive(Default)]
pub struct Loaded {
    /// The passes that were asked for.
    pub passes: Vec<LoadedPass>,
    /// Their jobs.
    pub nodes: Vec<Node>,
    /// What people should know and what stops nothing: warnings, jobs that wait for data and the command that brings
    /// them.
    pub notes: Vec<String>,
}

/// A job that waits for another's result.
struct After(Box<Deferred>);

impl Task for After {
    fn kind(&self) -> &'static str {
        self.0.job().kind()
    }

    fn algorithm_version(&self) -> u32 {
        self.0.job().algorithm_version()
    }

    fn identity(&self) -> Value {
        self.0.job().identity()
    }

    fn prepare(&self, upstream: &[Arc<Value>]) -> Result<Arc<dyn Job>, JobError> {
        let result = upstream.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
        self.0.prepare(result)
    }
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

/// The passes under these paths, all that is wrong with all of them in one message.
fn passes(paths: &[PathBuf], coloured: bool) -> Result<Vec<(PathBuf, PathBuf, Pass)>, Failure> {
    let studies = discover(paths).map_err(|error| Failure::input(error.to_string()))?;
    let mut loaded = Vec::new();
    let mut wrong = Vec::new();
    for study in studies {
        for path in study.passes {
            match crate::study::load(&path) {
                Ok(pass) => loaded.push((study.folder.clone(), path, pass)),
                Err(diagnostics) => wrong.push(diagnostics.render(coloured, MOST_DIAGNOSTICS)),
            }
        }
    }
    if wrong.is_empty() { Ok(loaded) } else { Err(Failure::input(wrong.join("\n"))) }
}

/// Loads the passes found under these paths.
///
/// # Errors
/// What is wrong with the files, rendered at its place.
pub fn load(paths: &[PathBuf], coloured: bool) -> Result<Loaded, Failure> {
    let mut all = Loaded::default();
    for (study, path, pass) in passes(paths, coloured)? {
        let shown = path.display().to_string();
        if !pass.warnings.is_empty() {
            all.notes.push(pass.warnings.render(coloured, MOST_DIAGNOSTICS));
        }
        let jobs = crate::study::ready(&pass)
            .map_err(|(job, error)| Failure::input(format!("{shown}: job `{job}`: {error}")))?;
        let mut entry = LoadedPass {
            file: pass.file.clone(),
            jobs: Vec::new(),
            not_run: Vec::new(),
            pass: Arc::new(pass),
            shown: shown.clone(),
            study,
        };
        for (name, readiness) in jobs {
            match readiness {
                Readiness::Ready(job) => {
                    let id = format!("{shown}:{name}");
                    entry.jobs.push(id.clone());
                    let node = Node { id, name, seed: entry.pass.seed, from: Vec::new(), task: Box::new(Ready(job)) };
                    all.nodes.push(node);
                }
                Readiness::After(deferred) => {
                    let id = format!("{shown}:{name}");
                    entry.jobs.push(id.clone());
                    let from = vec![format!("{shown}:{}", deferred.calibration)];
                    all.nodes.push(Node { id, name, seed: entry.pass.seed, from, task: Box::new(After(deferred)) });
                }
                Readiness::NotRun(reason) => {
                    all.notes.push(format!("{shown}: job `{name}` does not run: {reason}"));
                    entry.not_run.push(format!("Job {name} did not run: {reason}."));
                }
            }
        }
        all.passes.push(entry);
    }
    Ok(all)
}

/// That a path names one pass, for verbs that print one.
///
/// # Errors
/// A folder of several passes, each named; a path that is none.
pub fn one_pass(path: &Path) -> Result<(), Failure> {
    let found = discover(&[path.to_owned()]).map_err(|error| Failure::input(error.to_string()))?;
    let passes: Vec<_> = found.iter().flat_map(|study| &study.passes).collect();
    if passes.len() == 1 {
        return Ok(());
    }
    let names: Vec<_> = passes.iter().map(|pass| escaped(&pass.display().to_string())).collect();
    Err(Failure::input(format!("`{}` holds several passes; name one: {}", path.display(), names.join(", "))))
}

/// That a pass defines a job.
///
/// # Errors
/// The jobs that it does define.
pub fn has_job(pass: &LoadedPass, job: &str) -> Result<(), Failure> {
    let names = || pass.pass.jobs.iter().map(|named| named.name.as_str());
    if names().any(|name| name == job) {
        return Ok(());
    }
    let known: Vec<_> = names().map(|name| format!("`{}`", escaped(name))).collect();
    let (shown, job) = (&pass.shown, escaped(job));
    Err(Failure::input(if known.is_empty() {
        format!("`{shown}` has no job `{job}`, and no other")
    } else {
        format!("`{shown}` has no job `{job}`; its jobs are {}", known.join(", "))
    }))
}

/// The report's view of a pass with its finished jobs, without what only an archived report needs.
///
/// # Errors
/// A result that cannot be read.
pub fn view<'p>(pass: &'p LoadedPass, executed: &Executed) -> Result<PassReport<'p>, Failure> {
    view_in(pass, executed, Surroundings::default())
}

fn view_in<'p>(
    pass: &'p LoadedPass,
    executed: &Executed,
    surroundings: Surroundings,
) -> Result<PassReport<'p>, Failure> {
    let jobs: Vec<FinishedJob<'_>> = executed
        .results(pass)
        .map(|(position, job)| {
            let node = &executed.plan.nodes()[position];
            FinishedJob { name: &node.name, kind: node.task.kind(), key: job.key.as_str(), result: &job.stored.value }
        })
        .collect();
    let surroundings = Surroundings { study: study_name(&pass.study), warnings: pass.not_run.clone(), ..surroundings };
    assemble(&pass.pass, &jobs, surroundings).map_err(|error| Failure::job(format!("{}: {error}", pass.shown)))
}

/// Takes the single readings out of comparisons; a terminal shows their statistics.
pub fn without_rows(report: &mut PassReport<'_>) {
    for job in &mut report.results {
        if let JobResult::Compare(output) = &mut job.result {
            output.rows.clear();
        }
    }
}

/// A job's result for other programs; `with_rows` keeps the single readings of a comparison.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn document(job: &JobEntry, with_rows: bool) -> Result<Value, Failure> {
    match &job.result {
        JobResult::Propagate(output) => Ok(propagate::view(output)),
        JobResult::Compare(output) => Ok(compare::view(output, with_rows)),
        JobResult::Calibrate(output) => {
            serde_json::to_value(output).map_err(|error| Failure::job(format!("{}: {error}", job.name)))
        }
        JobResult::Design(output) => {
            serde_json::to_value(output).map_err(|error| Failure::job(format!("{}: {error}", job.name)))
        }
        JobResult::Conventional(output) => {
            serde_json::to_value(output).map_err(|error| Failure::job(format!("{}: {error}", job.name)))
        }
    }
}

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
    for (role, file) in input_files(&pass.pass) {
        let path = pass.study.join(&file);
        let record = crate::runner::manifest::hash_file(&path).map_err(|error| failed(error.to_string()))?;
        files.push(FileHash { path: file, sha256: record.sha256.as_str().to_owned(), role: role.to_owned() });
        manifest.add_input_record(&path.display().to_string(), record);
    }
    for (position, job) in executed.results(pass) {
        manifest.add_job(&executed.plan.nodes()[position], job);
    }
    let engine_version = ENGINE_VERSION.to_string();
    let view = view_in(pass, executed, Surroundings { files, engine_version, command, ..Surroundings::default() })?;
    let rendered = report::render(&view).map_err(|error| failed(error.to_string()))?;
    let folder = out.join(&view.study).join(pass.file.trim_end_matches(".json"));
    report::write(&rendered, &folder).map_err(|error| failed(error.to_string()))?;
    manifest.add_outputs(&folder)?;
    manifest.write(&folder)?;
    Ok(Some(folder))
}

/// A study's name: that of its folder.
fn study_name(folder: &Path) -> String {
    let resolved = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    resolved.file_name().map_or_else(|| "study".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Files of the study that a pass is made of, with their roles.
fn input_files(pass: &Pass) -> Vec<(&'static str, String)> {
    let mut files = vec![("model", pass.model_file.clone()), ("pass", pass.file.clone())];
    files.extend(pass.parents.iter().map(|parent| ("parent pass", parent.clone())));
    for file in pass.adopted.iter().filter_map(|adopted| adopted.file.clone()) {
        if !files.iter().any(|(_, known)| *known == file) {
            files.push(("effect", file));
        }
    }
    for measurement in &pass.measurements {
        if !files.iter().any(|(_, file)| *file == measurement.file) {
            files.push(("data", measurement.file.clone()));
        }
    }
    files
}

/// Checks pinned measurements, or brings them first if `bring`; `from` is a folder to search.
///
/// # Errors
/// What is wrong with the files.
pub fn pinned(paths: &[PathBuf], bring: bool, from: Option<&Path>) -> Result<Vec<PinnedFile>, Failure> {
    let folders = pinned::search_folders(from, std::env::var_os("BMV_DATA").as_deref());
    let mut found: Vec<PinnedFile> = Vec::new();
    for (study, _, pass) in passes(paths, false)? {
        let folder = Folder::open(&study).map_err(|error| Failure::input(error.to_string()))?;
        for entry in &pass.pinned {
            let file = study.join(&entry.file).display().to_string();
            if found.iter().any(|known| known.file == file) {
                continue;
            }
            let (state, good) = if bring {
                match pinned::get(&folder, entry, &folders) {
                    Ok(Obtained::AlreadyThere) => ("already there".to_owned(), true),
                    Ok(Obtained::Copied(path)) => (format!("copied from {}", path.display()), true),
                    Ok(Obtained::Fetched(origin)) => (format!("fetched from {origin}"), true),
                    Err(error) => (error.to_string(), false),
                }
            } else {
                match pinned::verify(&folder, entry) {
                    Ok(State::Good) => ("the pinned bytes".to_owned(), true),
                    Ok(State::Absent) => ("not there".to_owned(), false),
                    Ok(State::Other { sha256 }) => (format!("other bytes, SHA-256 {sha256}"), false),
                    Err(error) => (error.to_string(), false),
                }
            };
            found.push(PinnedFile { file, state, good });
        }
    }
    Ok(found)
}

/// JSON Schema of a file format: `model`, `pass`, `effect`, `results`. Nothing for a name that is none of them.
pub fn schema(format: &str) -> Option<Value> {
    match format {
        "results" => Some(report::results_schema()),
        _ => crate::study::schema(format).ok(),
    }
}
