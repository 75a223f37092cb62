//! Tests of `src/runner/error.rs`.

use bmv::job::JobError;
use bmv::runner::error::*;

#[test]
fn a_failed_block_names_its_place() {
    let error = RunnerError::Job {
        job: "tuned".into(),
        stage: Some("chains".into()),
        block: Some(3),
        source: JobError::Failed("no path to a boundary".into()),
    };
    assert_eq!(error.to_string(), "job `tuned`, stage `chains`, block 3: no path to a boundary");
    let error =
        RunnerError::Job { job: "tuned".into(), stage: None, block: None, source: JobError::Failed("x".into()) };
    assert_eq!(error.to_string(), "job `tuned`: x");
}

#[test]
fn a_circle_is_written_as_one() {
    let error = RunnerError::Cycle { jobs: vec!["a".into(), "b".into(), "a".into()] };
    assert_eq!(error.to_string(), "jobs build upon one another in a circle: a -> b -> a");
}
