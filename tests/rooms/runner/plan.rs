//! Tests of `src/runner/plan.rs`.

use std::collections::BTreeSet;
use std::sync::Arc;

use bmv::job::{JobError, Runnable};
use bmv::runner::cache::{Cache, Kind};
use bmv::runner::event_log::WorkHistory;
use bmv::runner::plan::*;
use serde_json::{Value, json};

struct Named(&'static str);

impl Task for Named {
    fn kind(&self) -> &'static str {
        "toy"
    }
    fn algorithm_version(&self) -> u32 {
        1
    }
    fn identity(&self) -> Value {
        json!({ "what": self.0 })
    }
    fn prepare(&self, _upstream: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        Err(JobError::Failed("never run here".into()))
    }
}

fn node(id: &'static str, from: &[&str]) -> Node {
    Node {
        id: id.into(),
        name: id.into(),
        seed: 1,
        from: from.iter().map(|&id| id.into()).collect(),
        task: Box::new(Named(id)),
    }
}

fn ids(plan: &Plan) -> Vec<&str> {
    plan.nodes().iter().map(|node| node.id.as_str()).collect()
}

#[test]
fn jobs_stand_after_what_they_build_upon() {
    let plan = Plan::new(vec![node("c", &["b", "a"]), node("b", &["a"]), node("a", &[]), node("d", &[])]).unwrap();
    assert_eq!(ids(&plan), ["a", "b", "c", "d"]);
    assert_eq!(plan.upstream(2), [1, 0]);
    assert_eq!(plan.material(2).upstream, [plan.keys()[1].clone(), plan.keys()[0].clone()]);
}

#[test]
fn a_change_upstream_changes_all_keys_below() {
    let before = Plan::new(vec![node("a", &[]), node("b", &["a"]), node("c", &[])]).unwrap();
    let mut nodes = vec![node("a", &[]), node("b", &["a"]), node("c", &[])];
    nodes[0].task = Box::new(Named("changed"));
    let after = Plan::new(nodes).unwrap();
    let same: Vec<_> = before.keys().iter().zip(after.keys()).map(|(a, b)| a == b).collect();
    assert_eq!(same, [false, false, true]);
}

#[test]
fn circles_strangers_and_twins_are_refused() {
    let error = Plan::new(vec![node("x", &["a"]), node("a", &["b"]), node("b", &["a"])]).err().unwrap();
    assert_eq!(error.to_string(), "jobs build upon one another in a circle: a -> b -> a");
    let error = Plan::new(vec![node("a", &["a"])]).err().unwrap();
    assert_eq!(error.to_string(), "jobs build upon one another in a circle: a -> a");
    let error = Plan::new(vec![node("a", &["z"])]).err().unwrap();
    assert_eq!(error.to_string(), "job `a` builds upon `z`, which does not exist");
    let error = Plan::new(vec![node("a", &[]), node("a", &[])]).err().unwrap();
    assert_eq!(error.to_string(), "two jobs are called `a`");
}

#[test]
fn a_long_chain_is_ordered_without_recursion() {
    let count = 100_000;
    let upstream: Vec<Vec<usize>> = (0..count).map(|i| if i + 1 < count { vec![i + 1] } else { vec![] }).collect();
    assert_eq!(order(&upstream).unwrap(), (0..count).rev().collect::<Vec<_>>());
}

#[test]
fn only_what_is_wanted_and_what_that_needs_would_run() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let plan = Plan::new(vec![node("a", &[]), node("b", &["a"]), node("c", &["b"]), node("d", &[])]).unwrap();
    let only = BTreeSet::from(["c".to_owned()]);
    let jobs = |force| -> Vec<(String, bool)> {
        let lines = plan.preview(&cache, Some(&only), force, &WorkHistory::default());
        lines.into_iter().map(|line| (line.job, line.cached)).collect()
    };
    assert_eq!(jobs(false), [("a".into(), false), ("b".into(), false), ("c".into(), false)]);
    cache.put(Kind::Result, &plan.keys()[1], &plan.keys()[1], b"{}").unwrap();
    assert_eq!(jobs(false), [("b".into(), true), ("c".into(), false)], "b is cached, so a is not needed");
    cache.put(Kind::Result, &plan.keys()[2], &plan.keys()[2], b"{}").unwrap();
    assert_eq!(jobs(false), [("c".into(), true)]);
    assert_eq!(jobs(true), [("b".into(), true), ("c".into(), false)], "forced: run again, from cached upstream");
}

#[test]
fn a_job_is_found_by_id_or_by_a_name_that_is_unique() {
    let mut nodes = vec![node("1:a", &[]), node("2:a", &[]), node("2:b", &[])];
    for (node, name) in nodes.iter_mut().zip(["a", "a", "b"]) {
        node.name = name.into();
    }
    let plan = Plan::new(nodes).unwrap();
    assert_eq!(plan.find("2:a"), Some(1));
    assert_eq!(plan.find("b"), Some(2));
    assert_eq!(plan.find("a"), None);
}
