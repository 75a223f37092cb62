//! A study of a few files in a folder of its own, with `pass-1.json`, for the cases that diagnose one.

use std::path::Path;

use bmv::diagnosis::{Output, Problem};
use bmv::job::ready::Readiness;
use bmv::study::Pass;

use crate::serial;

/// Writes the files into a folder, and loads `pass-1.json` of them.
pub fn loaded(folder: &Path, files: &[(&str, &str)]) -> Pass {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("written");
    }
    bmv::job::load(&folder.join("pass-1.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20)))
}

/// The problem that a diagnosis of these files has.
pub fn problem(files: &[(&str, &str)]) -> Problem {
    let folder = tempfile::tempdir().expect("a folder");
    bmv::study::problem(&loaded(folder.path(), files))
}

/// The result of the pass's first job, a diagnosis.
pub fn diagnosed(pass: &Pass) -> Output {
    let (_, readiness) = bmv::job::ready(pass).into_iter().next().expect("a job");
    let Readiness::Ready(job) = readiness else { panic!("ready") };
    serde_json::from_value(serial::run(job.as_ref()).expect("a result")).expect("a diagnosis")
}
