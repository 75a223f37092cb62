//! Passes with their jobs, ready to plan: those that were asked for, and the jobs of others that these build upon.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::BatchError;
use super::graph::{add_upstream, id, in_study, node, remove_orphans};
use crate::document::{Diagnostic, Diagnostics};
use crate::job;
use crate::job::ready::{Readiness, Refusal};
use crate::runner::Node;
use crate::runner::external::Outside;
use crate::study::{Pass, Project, Reader, discover};

/// Diagnostics printed of one file.
const MOST_DIAGNOSTICS: usize = 50;

/// How passes are read.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Whether messages are coloured.
    pub coloured: bool,
    /// What asks models outside.
    pub outside: Arc<Outside>,
}

impl Reading {
    /// The same reading, by which a model outside that broke off is tried again.
    #[must_use]
    pub fn anew(&self) -> Self {
        Self { coloured: self.coloured, outside: Arc::new(self.outside.anew()) }
    }

    fn reader(&self) -> Reader {
        let outside: Arc<Outside> = Arc::clone(&self.outside);
        Reader::new(job::kinds()).with_lender(outside)
    }
}

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
    fn refuse(&mut self, name: &str, refusals: Vec<Refusal>) {
        let why: Vec<&str> = refusals.iter().map(|refusal| refusal.reason.as_str()).collect();
        self.not_run.push(format!("Job {name} has no result: {}.", why.join("; ")));
        let kind = self.pass.jobs.iter().find(|job| job.name == name).map_or("", |job| job.spec.kind());
        let diagnostics = refusals.into_iter().map(|refusal| refusal.diagnostic).collect();
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

/// The passes under these paths, all that is wrong with all of them in one message, each thing once.
pub fn passes(
    reader: &Reader,
    paths: &[PathBuf],
    coloured: bool,
) -> Result<Vec<(PathBuf, PathBuf, Arc<Pass>)>, BatchError> {
    let studies = discover(paths).map_err(|error| BatchError::input(error.to_string()))?;
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
    if wrong.is_empty() { Ok(loaded) } else { Err(BatchError::Rendered(wrong.join("\n"))) }
}

/// Loads the passes found under these paths, and the jobs of other passes of their studies that their jobs need. Where
/// a job cannot be made, only those that build on it do not run either.
///
/// # Errors
/// What is wrong with the files, rendered at its place.
pub fn load(paths: &[PathBuf], reading: &Reading) -> Result<Loaded, BatchError> {
    load_with(&reading.reader(), paths, reading.coloured)
}

/// As [`load`], with another seed than the passes state.
///
/// # Errors
/// As [`load`].
pub fn load_with_seed(paths: &[PathBuf], seed: u64, reading: &Reading) -> Result<Loaded, BatchError> {
    load_with(&reading.reader().with_seed(seed), paths, reading.coloured)
}

fn load_with(reader: &Reader, paths: &[PathBuf], coloured: bool) -> Result<Loaded, BatchError> {
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
                Readiness::Refused(refusals) => entry.refuse(&name, refusals.clone()),
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
    for (orphan, missing) in remove_orphans(&mut all.nodes) {
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
        let mut refusals = vec![Refusal::new(job, reason)];
        // Of a pass that was not asked for nothing else tells what is wrong.
        refusals.extend(refused.get(&missing).into_iter().flatten().cloned().map(Refusal::from));
        entry.refuse(&job.name, refusals);
    }
    Ok(all)
}

/// The parents of passes, as far as they are not among them and can be loaded by themselves.
pub fn parents(passes: &[LoadedPass], reading: &Reading) -> Loaded {
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
    let reader = reading.reader();
    for path in wanted {
        // A parent may lack what its children add; its own report then tells what is wrong with it.
        let Ok(loaded) = load_with(&reader, &[path], false) else { continue };
        all.passes.extend(loaded.passes);
        all.nodes.extend(loaded.nodes);
    }
    all
}
