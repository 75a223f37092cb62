//! The graph of jobs across passes: what the runner is given of each, and what each builds upon.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::load::LoadedPass;
use crate::document::Diagnostic;
use crate::job::ready::{Deferred, Readiness};
use crate::job::{self, JobError, Runnable};
use crate::runner::{Node, Ready, Task};
use crate::study::Pass;
use crate::study::resolved::Upstream;

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

/// The id of a job of a pass.
pub(super) fn id(shown: &str, job: &str) -> String {
    format!("{shown}:{job}")
}

/// A job by its id, as the passes of its study speak of it: the same wherever the study lies.
pub(super) fn in_study(id: &str) -> String {
    let (pass, job) = id.rsplit_once(':').unwrap_or(("", id));
    let file = Path::new(pass).file_name().map_or_else(|| pass.into(), |name| name.to_string_lossy());
    format!("`{job}` of `{file}`")
}

/// The path of a pass of a study, as people see it.
fn shown(folder: &Path, file: &str) -> String {
    folder.join(file).display().to_string()
}

/// A job as the runner is given it, and the jobs of other passes that it needs (file, name); nothing where it does not run.
pub(super) fn node(
    shown_pass: &str,
    pass: &Pass,
    name: String,
    readiness: Readiness,
) -> Option<(Node, Vec<(String, String)>)> {
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
pub(super) fn add_upstream(
    nodes: &mut Vec<Node>,
    refused: &mut BTreeMap<String, Vec<Diagnostic>>,
    pass: &Pass,
    needed: Vec<(String, String)>,
) {
    for other in &pass.upstream {
        let mut wanted: Vec<String> =
            needed.iter().filter(|(file, _)| *file == other.file).map(|(_, job)| job.clone()).collect();
        let shown_pass = shown(&other.folder, &other.file);
        let is_there = |nodes: &[Node], job: &str| nodes.iter().any(|node| node.id == id(&shown_pass, job));
        if wanted.iter().all(|job| is_there(nodes, job)) {
            continue;
        }
        let mut further = Vec::new();
        let mut others = job::ready(other);
        // What they build on in their own pass comes with them.
        while let Some(name) = wanted.pop() {
            let Some(place) = others.iter().position(|(own, _)| *own == name) else { continue };
            let (_, readiness) = others.swap_remove(place);
            if is_there(nodes, &name) {
                continue;
            }
            if let Readiness::Refused(refusals) = &readiness {
                let diagnostics = refusals.iter().map(|refusal| refusal.diagnostic.clone()).collect();
                refused.insert(id(&shown_pass, &name), diagnostics);
            }
            if let Some((node, needed)) = node(&shown_pass, other, name, readiness) {
                nodes.push(node);
                let own = needed.iter().filter(|(file, _)| *file == other.file);
                wanted.extend(own.map(|(_, job)| job.clone()));
                further.extend(needed);
            }
        }
        add_upstream(nodes, refused, other, further);
    }
}

/// Takes the jobs out that build on one that is not among them, and those that build on these: gives id and what is
/// missing.
pub(super) fn remove_orphans(nodes: &mut Vec<Node>) -> Vec<(String, String)> {
    let mut orphans = Vec::new();
    loop {
        let node_ids: BTreeSet<String> = nodes.iter().map(|node| node.id.clone()).collect();
        let missing = |node: &Node| node.from.iter().find(|from| !node_ids.contains(*from)).cloned();
        let before = orphans.len();
        orphans.extend(nodes.iter().filter_map(|node| Some((node.id.clone(), missing(node)?))));
        if orphans.len() == before {
            return orphans;
        }
        nodes.retain(|node| missing(node).is_none());
    }
}

/// A comparison of a pass as the runner is given it without its tuned state, and the calibration that it leaves out.
pub fn delivered(pass: &LoadedPass, name: &str) -> Option<(Node, String)> {
    let job = pass.pass.jobs.iter().find(|job| job.name == name)?;
    let calibration = job.spec.comparison()?.calibration?.to_owned();
    let (node, _) = node(&pass.shown, &pass.pass, job.name.clone(), job::delivered(&pass.pass, job)?)?;
    Some((node, calibration))
}
