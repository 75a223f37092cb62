//! Where the verbs meet the rooms that load studies and render reports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::archive::study_name;
use super::execute::Executed;
use super::output::{self, escaped, tell};
use super::status::Failure;
use crate::document::{Diagnostic, Diagnostics};
use crate::job::ready::{Deferred, Readiness};
use crate::job::{self, JobError, Runnable};
use crate::report::assemble::{FinishedJob, Surroundings, assemble};
use crate::report::{History, JobEntry, PassErrors, PassReport};
use crate::runner::{Node, Outcome, Ready, RunnerError, Task};
use crate::study::resolved::Upstream;
use crate::study::{self, Pass, Project, Reader, discover};

/// Diagnostics printed of one file.
const MOST_DIAGNOSTICS: usize = 50;

/// A pass that was asked for.
#[derive(Clone, Debug)]
pub struct LoadedPass {
    /// Path of the pass file, as people see it.
    pub shown: String,
    /// Folder of the study.
    pub study: PathBuf,
    /// The project in which it lies.
    pub project: Project,
    /// Name of the pass file in it.
    pub file: String,
    /// Ids of its jobs, in the order of the file.
    pub jobs: Vec<String>,
    /// Jobs that do not run now, each with its reason.
    pub not_run: Vec<String>,
    /// Jobs that cannot be made from their definition.
    pub refused: Vec<RefusedJob>,
    /// The pass.
    pub pass: Arc<Pass>,
}

/// A job that cannot be made from its definition.
#[derive(Clone, Debug)]
pub struct RefusedJob {
    /// Kind.
    pub kind: String,
    /// Name.
    pub name: String,
    /// What is wrong, at its place.
    pub diagnostics: Vec<Diagnostic>,
}

impl LoadedPass {
    /// Notes that a job cannot be made.
    fn refuse(&mut self, name: &str, diagnostics: Vec<Diagnostic>) {
        let prefix = job::refusal_prefix(name);
        let plain = |message: &'_ String| message.strip_prefix(&prefix).unwrap_or(message).to_owned();
        let why: Vec<String> = diagnostics.iter().map(|diagnostic| plain(&diagnostic.message)).collect();
        self.not_run.push(format!("Job {name} has no result: {}.", why.join("; ")));
        let kind = self.pass.jobs.iter().find(|job| job.name == name).map_or("", |job| job.spec.kind());
        self.refused.push(RefusedJob { kind: kind.to_owned(), name: name.to_owned(), diagnostics });
    }
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

/// A job that waits for results of others.
struct After(Box<Deferred>);

impl Task for After {
    fn kind(&self) -> &'static str {
        self.0.job().kind()
    }

    fn algorithm_version(&self) -> u32 {
        self.0.job().algorithm_version()
    }

    fn identity(&self) -> Value {
        self.0.identity()
    }

    fn memory_bytes(&self) -> u64 {
        self.0.job().memory_bytes()
    }

    fn prepare(&self, upstream: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        self.0.prepare(upstream)
    }
}

/// The passes under these paths, all that is wrong with all of them in one message, each thing once.
pub(super) fn passes(
    reader: &Reader,
    paths: &[PathBuf],
    coloured: bool,
) -> Result<Vec<(PathBuf, PathBuf, Arc<Pass>)>, Failure> {
    let studies = discover(paths).map_err(|error| Failure::input(error.to_string()))?;
    let mut loaded = Vec::new();
    let mut wrong = Vec::new();
    let mut said = Diagnostics::new();
    for study in studies {
        for path in study.passes {
            match reader.load(&path) {
                Ok(pass) => loaded.push((study.folder.clone(), path, pass)),
                Err(diagnostics) => {
                    // A pass tells what is wrong with the passes that it builds upon too.
                    wrong.push(diagnostics.without(&said).render(coloured, MOST_DIAGNOSTICS));
                    said.extend(&diagnostics);
                }
            }
        }
    }
    if wrong.is_empty() { Ok(loaded) } else { Err(Failure::input(wrong.join("\n"))) }
}

/// The id of a job of a pass.
fn id(shown: &str, job: &str) -> String {
    format!("{shown}:{job}")
}

/// A job by its id, as the passes of its study speak of it: the same wherever the study lies.
fn in_study(id: &str) -> String {
    let (pass, job) = id.rsplit_once(':').unwrap_or(("", id));
    let file = Path::new(pass).file_name().map_or_else(|| pass.into(), |name| name.to_string_lossy());
    format!("`{job}` of `{file}`")
}

/// The path of a pass of a study, as people see it.
fn shown(folder: &Path, file: &str) -> String {
    folder.join(file).display().to_string()
}

/// A job as the runner is given it, and the jobs of other passes that it needs (file, name); nothing where it does not run.
fn node(shown_pass: &str, pass: &Pass, name: String, readiness: Readiness) -> Option<(Node, Vec<(String, String)>)> {
    let (from, task): (Vec<Upstream>, Box<dyn Task>) = match readiness {
        Readiness::Ready(job) => (Vec::new(), Box::new(Ready(job))),
        Readiness::After(deferred) => (deferred.from.clone(), Box::new(After(deferred))),
        Readiness::NotRun(_) | Readiness::Refused(_) => return None,
    };
    let is_own = |upstream: &&Upstream| upstream.file == pass.file;
    let ids = from.iter().map(|upstream| {
        if is_own(&upstream) {
            id(shown_pass, &upstream.job)
        } else {
            id(&shown(&pass.folder, &upstream.file), &upstream.job)
        }
    });
    let others = from.iter().map(|upstream| (upstream.file.clone(), upstream.job.clone())).collect();
    let node = Node { id: id(shown_pass, &name), name, seed: pass.seed, from: ids.collect(), task };
    Some((node, others))
}

/// Adds the jobs of other passes that a pass's jobs need, and those that these need; `refused` gets what is wrong with
/// those that cannot be made, by id.
fn add_upstream(
    nodes: &mut Vec<Node>,
    refused: &mut BTreeMap<String, Vec<Diagnostic>>,
    pass: &Pass,
    needed: Vec<(String, String)>,
) {
    for other in &pass.upstream {
        let wanted: Vec<&String> = needed.iter().filter(|(file, _)| *file == other.file).map(|(_, job)| job).collect();
        let shown_pass = shown(&other.folder, &other.file);
        let is_there = |nodes: &[Node], job: &str| nodes.iter().any(|node| node.id == id(&shown_pass, job));
        if wanted.iter().all(|job| is_there(nodes, job)) {
            continue;
        }
        let mut further = Vec::new();
        for (name, readiness) in job::ready(other) {
            if !wanted.contains(&&name) || is_there(nodes, &name) {
                continue;
            }
            if let Readiness::Refused(diagnostics) = &readiness {
                refused.insert(id(&shown_pass, &name), diagnostics.clone());
            }
            if let Some((node, needed)) = node(&shown_pass, other, name, readiness) {
                nodes.push(node);
                further.extend(needed);
            }
        }
        add_upstream(nodes, refused, other, further);
    }
}

/// Takes the jobs out that build on one that is not among them, and those that build on these: gives id and what is
/// missing.
fn take_orphans(nodes: &mut Vec<Node>) -> Vec<(String, String)> {
    let mut orphans = Vec::new();
    loop {
        let known: BTreeSet<String> = nodes.iter().map(|node| node.id.clone()).collect();
        let missing = |node: &Node| node.from.iter().find(|from| !known.contains(*from)).cloned();
        let before = orphans.len();
        orphans.extend(nodes.iter().filter_map(|node| Some((node.id.clone(), missing(node)?))));
        if orphans.len() == before {
            return orphans;
        }
        nodes.retain(|node| missing(node).is_none());
    }
}

/// Loads the passes found under these paths, and the jobs of other passes of their studies that their jobs need. A job
/// that cannot be made keeps none but those from running that build on it.
///
/// # Errors
/// What is wrong with the files, rendered at its place.
pub fn load(paths: &[PathBuf], coloured: bool) -> Result<Loaded, Failure> {
    load_with(&Reader::new(job::kinds()), paths, coloured)
}

fn load_with(reader: &Reader, paths: &[PathBuf], coloured: bool) -> Result<Loaded, Failure> {
    let mut all = Loaded::default();
    let mut needed = Vec::new();
    for (study, path, pass) in passes(reader, paths, coloured)? {
        let shown = path.display().to_string();
        if !pass.warnings.is_empty() {
            all.notes.push(pass.warnings.render(coloured, MOST_DIAGNOSTICS));
        }
        let mut entry = LoadedPass {
            file: pass.file.clone(),
            jobs: Vec::new(),
            not_run: Vec::new(),
            refused: Vec::new(),
            pass,
            shown: shown.clone(),
            project: Project::of(&study),
            study,
        };
        let pass = Arc::clone(&entry.pass);
        let mut own_needed = Vec::new();
        for (name, readiness) in job::ready(&pass) {
            match &readiness {
                Readiness::NotRun(reason) => {
                    entry.not_run.push(format!("Job {name} did not run: {reason}."));
                    all.notes.push(format!("{shown}: job `{name}` does not run: {reason}"));
                }
                Readiness::Refused(diagnostics) => entry.refuse(&name, diagnostics.clone()),
                Readiness::Ready(_) | Readiness::After(_) => {}
            }
            if let Some((node, needed)) = node(&shown, &pass, name, readiness) {
                entry.jobs.push(node.id.clone());
                all.nodes.push(node);
                own_needed.extend(needed);
            }
        }
        needed.push((pass, own_needed));
        all.passes.push(entry);
    }
    let mut refused = BTreeMap::new();
    for (pass, needed) in needed {
        add_upstream(&mut all.nodes, &mut refused, &pass, needed);
    }
    for (orphan, missing) in take_orphans(&mut all.nodes) {
        let Some(entry) = all.passes.iter_mut().find(|pass| pass.jobs.contains(&orphan)) else { continue };
        let pass = Arc::clone(&entry.pass);
        let Some(job) = pass.jobs.iter().find(|job| id(&entry.shown, &job.name) == orphan) else { continue };
        // A comparison shows what there is to show.
        if let Some(readiness) = job::delivered(&pass, job)
            && let Some((node, _)) = node(&entry.shown, &pass, job.name.clone(), readiness)
        {
            all.nodes.push(node);
            continue;
        }
        entry.jobs.retain(|id| *id != orphan);
        let reason = format!("it builds on {}, which has no result", in_study(&missing));
        let mut diagnostics = vec![job::refusal(job, reason)];
        // Of a pass that was not asked for nothing else tells what is wrong.
        diagnostics.extend(refused.get(&missing).into_iter().flatten().cloned());
        entry.refuse(&job.name, diagnostics);
    }
    Ok(all)
}

/// Tells what people should know of the files, each thing once.
pub fn tell_notes(notes: &[String]) {
    for (position, note) in notes.iter().enumerate() {
        if !notes[..position].contains(note) {
            tell(note);
        }
    }
}

/// A comparison of a pass as the runner is given it without its tuned state, and the calibration that it leaves out.
pub fn delivered(pass: &LoadedPass, name: &str) -> Option<(Node, String)> {
    let job = pass.pass.jobs.iter().find(|job| job.name == name)?;
    let calibration = job.spec.comparison()?.calibration?.to_owned();
    let (node, _) = node(&pass.shown, &pass.pass, job.name.clone(), job::delivered(&pass.pass, job)?)?;
    Some((node, calibration))
}

/// Tells what is wrong with the jobs that cannot be made, each thing once.
pub fn tell_refused(passes: &[LoadedPass], coloured: bool) {
    let mut said: Vec<&Diagnostic> = Vec::new();
    for diagnostic in passes.iter().flat_map(|pass| &pass.refused).flat_map(|refused| &refused.diagnostics) {
        if !said.contains(&diagnostic) {
            tell(&diagnostic.render(coloured));
            said.push(diagnostic);
        }
    }
}

/// The parents of passes, as far as they are not among them and can be loaded by themselves.
pub fn parents(passes: &[LoadedPass]) -> Loaded {
    let mut wanted: Vec<PathBuf> = Vec::new();
    for pass in passes {
        for parent in &pass.pass.parents {
            let is_there = passes.iter().any(|other| other.study == pass.study && other.file == *parent);
            let path = pass.study.join(parent);
            if !is_there && !wanted.contains(&path) {
                wanted.push(path);
            }
        }
    }
    let mut all = Loaded::default();
    let reader = Reader::new(job::kinds());
    for path in wanted {
        // A parent may lack what its children add; its own report then tells what is wrong with it.
        let Ok(loaded) = load_with(&reader, &[path], false) else { continue };
        all.passes.extend(loaded.passes);
        all.nodes.extend(loaded.nodes);
    }
    all
}

/// The error of passes of one study, each after its parents.
///
/// # Errors
/// A result that cannot be read.
pub fn history(passes: &[&LoadedPass], executed: &Executed) -> Result<History, Failure> {
    let names: Vec<(&str, &[String])> =
        passes.iter().map(|pass| (pass.file.as_str(), pass.pass.parents.as_slice())).collect();
    let mut history = History::default();
    for position in study::history::order(&names) {
        let pass = passes[position];
        let judge = study::history::judged_by(&pass.pass);
        let result = |name: Option<&str>| -> Option<(String, Arc<Value>)> {
            let is_own = |at: usize| Some(executed.plan.nodes()[at].name.as_str()) == name;
            let (at, job) = executed.results(pass).find(|&(at, _)| is_own(at))?;
            Some((executed.plan.nodes()[at].name.clone(), Arc::clone(&job.stored.value)))
        };
        let comparison = result(judge.map(|judge| judge.comparison));
        let calibration = result(judge.and_then(|judge| judge.calibration));
        let parent = pass.pass.parents.first();
        let parent = passes.iter().find(|other| Some(&other.file) == parent).map(|other| other.pass.as_ref());
        let errors = PassErrors::new(
            &pass.pass,
            parent,
            comparison.as_ref().map(|(name, value)| (name.as_str(), value.as_ref())),
            calibration.as_ref().map(|(name, value)| (name.as_str(), value.as_ref())),
        );
        history.passes.push(errors.map_err(|error| Failure::job(format!("{}: {error}", escaped(&pass.shown))))?);
    }
    Ok(history)
}

/// That a path names one pass, for verbs that print one.
///
/// # Errors
/// A folder of several passes, each named; a path that is none.
pub fn one_pass(path: &Path) -> Result<PathBuf, Failure> {
    let found = discover(&[path.to_owned()]).map_err(|error| Failure::input(error.to_string()))?;
    let passes: Vec<_> = found.iter().flat_map(|study| &study.passes).collect();
    if let [pass] = passes.as_slice() {
        return Ok((*pass).clone());
    }
    let names: Vec<_> = passes.iter().map(|pass| escaped(&pass.display().to_string())).collect();
    Err(Failure::input(format!("`{}` holds several passes; name one: {}", output::shown(path), names.join(", "))))
}

/// The job of a kind: the one of this name, else the first, in the order of the file; where there are several, it is
/// told which.
///
/// # Errors
/// A pass that cannot be loaded, or that has no such job.
pub fn job_of_kind(path: &Path, kind: &str, name: Option<&str>, coloured: bool) -> Result<String, Failure> {
    let shown = output::shown(path);
    let loaded = passes(&Reader::new(job::kinds()), &[path.to_owned()], coloured)?;
    let jobs = loaded.iter().flat_map(|(_, _, pass)| &pass.jobs).filter(|job| job.spec.kind() == kind);
    let jobs: Vec<&str> = jobs.map(|job| job.name.as_str()).collect();
    match (name, jobs.as_slice()) {
        (_, []) => {
            let example = format!("\"jobs\": {{\"missing\": {{\"{kind}\": {{}}}}}}");
            Err(Failure::input(format!("`{shown}` has no job of kind `{kind}`; give it one, as in {example}")))
        }
        (Some(name), jobs) if jobs.contains(&name) => Ok(name.to_owned()),
        (Some(name), jobs) => {
            let listed = crate::document::suggest::listed(jobs.iter().copied(), 12);
            let (name, listed) = (escaped(name), escaped(&listed));
            Err(Failure::input(format!("`{shown}` has no `{kind}` job `{name}`; it has {listed}")))
        }
        (None, [first, rest @ ..]) => {
            if !rest.is_empty() {
                let listed = crate::document::suggest::listed(rest.iter().copied(), 12);
                let (first, listed) = (escaped(first), escaped(&listed));
                tell(&format!("`{shown}` has several jobs of kind `{kind}`: `{first}` is taken; --job names {listed}"));
            }
            Ok((*first).to_owned())
        }
    }
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
    let (shown, job) = (escaped(&pass.shown), escaped(job));
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

/// Which of a pass's jobs failed or were skipped, each with the reason.
fn failures(pass: &LoadedPass, executed: &Executed) -> impl Iterator<Item = String> {
    pass.jobs.iter().filter_map(|id| {
        let name = &executed.plan.nodes()[executed.plan.find(id)?].name;
        match executed.summary.outcomes.get(id)? {
            Outcome::Failed(error) => {
                let reason = match error.as_ref() {
                    RunnerError::Job { source, .. } => source.to_string(),
                    RunnerError::NotCanonical { reason, .. } => reason.clone(),
                    // Where the two lie was told; a report names no place of this machine.
                    RunnerError::Nondeterministic { .. } => "computed twice, it gave two results".to_owned(),
                    other => other.to_string(),
                };
                Some(format!("Job {name} has no result: {reason}."))
            }
            Outcome::Skipped { upstream } => {
                Some(format!("Job {name} has no result: it builds on {}, which has none.", in_study(upstream)))
            }
            Outcome::Finished(_) | Outcome::Interrupted => None,
        }
    })
}

pub(super) fn view_in<'p>(
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
    let warnings = pass.not_run.iter().cloned().chain(failures(pass, executed)).collect();
    let surroundings = Surroundings { study: study_name(&pass.study), warnings, ..surroundings };
    assemble(&pass.pass, &jobs, surroundings)
        .map_err(|error| Failure::job(format!("{}: {error}", escaped(&pass.shown))))
}

/// Takes the single readings out of results; a terminal shows their statistics.
pub fn without_rows(report: &mut PassReport<'_>) {
    for job in &mut report.results {
        if let Some(output) = job.output.without_rows() {
            job.output = output;
        }
    }
}

/// A job's result for other programs; `with_rows` keeps the single readings.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn document(job: &JobEntry, with_rows: bool) -> Result<Value, Failure> {
    job.output.document(with_rows).map_err(|error| Failure::job(format!("{}: {error}", job.name)))
}
