//! Tests of `src/runner/event_log.rs`.

use bmv::runner::Listener;
use std::fs;

use bmv::runner::event_log::*;
use bmv::runner::events::Event;
use bmv::runner::key::Key;

fn finished(job: &str, key: &Key, work_s: f64, blocks_cached: usize) -> Event {
    Event::JobFinished {
        job: job.into(),
        kind: "propagate".into(),
        key: key.clone(),
        blocks_run: 3,
        blocks_cached,
        work_s,
    }
}

#[test]
fn history_prefers_the_same_key_and_ignores_resumed_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (Key::of(b"old"), Key::of(b"new"));
    let log = EventLog::create(folder.path()).unwrap();
    log.hear(&finished("a", &old, 2.5, 0));
    log.hear(&finished("a", &new, 7.0, 0));
    log.hear(&finished("a", &Key::of(b"resumed"), 0.1, 5));
    drop(log);
    fs::write(folder.path().join("0-torn.jsonl"), "{\"at_s\": 1, \"event\": {\"job-finished\": {").unwrap();
    let history = WorkHistory::read(folder.path());
    assert_eq!(history.work_s("a", &old), Some(2.5));
    assert_eq!(history.work_s("a", &Key::of(b"third")), Some(7.0));
    assert_eq!(history.work_s("b", &Key::of(b"third")), None);
    assert_eq!(WorkHistory::read(&folder.path().join("missing")), WorkHistory::default());
}

#[test]
fn a_line_has_a_time_and_the_event() {
    let folder = tempfile::tempdir().unwrap();
    let log = EventLog::create(folder.path()).unwrap();
    log.hear(&Event::RunStarted { to_run: 2, cached: 1, threads: 2, engine: None });
    let line: serde_json::Value = serde_json::from_str(&fs::read_to_string(log.path()).unwrap()).unwrap();
    assert!(line["at_s"].as_f64().unwrap() > 1.7e9);
    assert_eq!(line["event"]["run-started"]["to_run"], 2);
}

#[cfg(unix)]
#[test]
fn what_is_no_log_is_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("0-pipe.jsonl");
    assert!(std::process::Command::new("mkfifo").arg(pipe).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("0-zero.jsonl")).unwrap();
    assert_eq!(WorkHistory::read(folder.path()), WorkHistory::default());
}

#[test]
fn old_logs_go() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..60 {
        fs::write(folder.path().join(format!("{number:015}-1.jsonl")), "").unwrap();
    }
    EventLog::create(folder.path()).unwrap();
    let logs = logs(folder.path());
    assert_eq!(logs.len(), LOGS_KEPT);
    assert!(logs[0].ends_with("000000000000011-1.jsonl"), "{:?}", logs[0]);
}
