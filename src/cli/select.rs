//! The pass and the job that a verb is about.

use std::path::{Path, PathBuf};

use super::output::{self, escaped, tell};
use super::status::Failure;
use crate::batch::{LoadedPass, passes};
use crate::job;
use crate::study::{Reader, discover};

/// That a path names one pass, for verbs that print one.
///
/// # Errors
/// A folder of several passes, each named; a path that is none.
pub fn one_pass(path: &Path) -> Result<PathBuf, Failure> {
    let studies = discover(&[path.to_owned()]).map_err(|error| Failure::input(error.to_string()))?;
    let passes: Vec<_> = studies.iter().flat_map(|study| &study.passes).collect();
    if let [pass] = passes.as_slice() {
        return Ok((*pass).clone());
    }
    let names: Vec<_> = passes.iter().map(|pass| escaped(&pass.display().to_string())).collect();
    Err(Failure::input(format!("`{}` holds several passes; name one: {}", output::shown(path), names.join(", "))))
}

/// The job of a kind: the one of this name, else the first, in the order of the file; where there are several, it is
/// stated which.
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
    let job_names: Vec<_> = names().map(|name| format!("`{}`", escaped(name))).collect();
    let (shown, job) = (escaped(&pass.shown), escaped(job));
    Err(Failure::input(if job_names.is_empty() {
        format!("`{shown}` has no job `{job}`, and no other")
    } else {
        format!("`{shown}` has no job `{job}`; its jobs are {}", job_names.join(", "))
    }))
}
