//! The local engine: thread counts, resuming, failures, interruption.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use bmv::job::{Done, Job, JobError, Parts, Runnable, Step};
use bmv::runner::engine::local;
use bmv::runner::{Cache, Event, Key, Kind, Manifest, Outcome, Plan, RunnerError, Settings, StopFlag};

use super::toy::{Fault, Harmonic, Heard, following, node, run, settings, single};

fn graph() -> Plan {
    Plan::new(vec![
        following("c", &["a", "b"]),
        node("a", Arc::new(Harmonic::new(5000))),
        node("b", Arc::new(Harmonic::new(700))),
        following("d", &["c"]),
        node("e", Arc::new(Harmonic::new(0))),
    ])
    .expect("no circle")
}

#[test]
#[ignore = "thorough"]
fn one_two_and_seven_threads_give_the_same_bytes() {
    let mut stored = Vec::new();
    for threads in [1, 2, 7] {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let plan = graph();
        let summary = run(&plan, &cache, threads);
        assert_eq!(summary.failures(), 0);
        // Not only the results: every object in the cache has the same name and the same bytes.
        let mut objects = Vec::new();
        for entry in walkdir::WalkDir::new(folder.path().join("objects")).sort_by_file_name() {
            let entry = entry.unwrap();
            if entry.file_type().is_file() {
                let name = entry.path().strip_prefix(folder.path()).unwrap().to_path_buf();
                objects.push((name, std::fs::read(entry.path()).unwrap()));
            }
        }
        assert!(objects.len() > 60, "{}", objects.len());
        stored.push(objects);
    }
    assert!(stored[0] == stored[1] && stored[1] == stored[2]);
}

#[test]
fn the_result_is_the_sum_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let summary = run(&single(&Arc::new(Harmonic::new(250))), &cache, 2);
    // Written out independently: H(250) = 6.10... , so 6 + 3 fine blocks of 100 from 0, 50, ..., 400, cut at 250.
    let coarse: f64 = (1..=250).map(|i| 1.0 / f64::from(i)).sum();
    assert_eq!(coarse as usize, 6);
    let fine: f64 =
        (0..9).map(|b| (b * 50..(b * 50 + 100).min(250)).map(|i| 7.0 / (f64::from(i) + 1.0)).sum::<f64>()).sum();
    let value = &summary.finished("sum").unwrap().stored.value;
    assert_eq!(value["blocks"], 9);
    // Another order of the same few hundred positive terms: relative rounding below 1e-13.
    assert!((value["sum"].as_f64().unwrap() / fine - 1.0).abs() < 1e-13);
}

#[test]
fn the_second_run_takes_all_from_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic::new(1000));
    let first = run(&single(&job), &cache, 2);
    let blocks = job.blocks_run.load(Ordering::Relaxed);
    let finished = first.finished("sum").unwrap();
    let mut manifest = Manifest::new("bmv report");
    manifest.add_job("sum", &single(&job).nodes()[0], finished);
    assert_eq!(manifest.jobs["sum"].key, single(&job).keys()[0]);
    let object = std::fs::read(cache.path(&finished.key)).unwrap();
    let trailer = object.iter().rev().skip(1).position(|&byte| byte == b'\n').unwrap() + 2;
    assert_eq!(manifest.jobs["sum"].result_sha256, Key::of(&object[..object.len() - trailer]));
    assert_eq!((finished.cached, finished.blocks_run), (false, blocks));
    let second = run(&single(&job), &cache, 2);
    assert_eq!(job.blocks_run.load(Ordering::Relaxed), blocks, "no block ran");
    let again = second.finished("sum").unwrap();
    assert!(again.cached);
    assert_eq!(again.stored, finished.stored, "the same value, found or computed");
}

#[test]
fn force_runs_again_and_finds_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic::new(1000));
    run(&single(&job), &cache, 2);
    let blocks = job.blocks_run.load(Ordering::Relaxed);
    let forced = Settings { force: true, ..settings(2) };
    let summary = local::run(&single(&job), &cache, &forced, &StopFlag::default(), &Heard::default()).unwrap();
    assert!(!summary.finished("sum").unwrap().cached);
    assert_eq!(job.blocks_run.load(Ordering::Relaxed), 2 * blocks);
}

#[test]
fn a_killed_run_goes_on_with_the_missing_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let whole = Cache::new(folder.path().join("whole"));
    let expected = run(&single(&Arc::new(Harmonic::new(3000))), &whole, 1);

    // All 30 blocks of the first stage are there, and the process ends in its reduction.
    let killed = Arc::new(Harmonic::new(3000));
    killed.reduce_panics.store(true, Ordering::Relaxed);
    run(&single(&killed), &cache, 2);
    assert_eq!(killed.blocks_run.load(Ordering::Relaxed), 30);

    let resumed = Arc::new(Harmonic::new(3000));
    let summary = run(&single(&resumed), &cache, 2);
    let finished = summary.finished("sum").unwrap();
    assert_eq!(finished.blocks_cached, 30);
    assert_eq!(finished.blocks_run, resumed.blocks_run.load(Ordering::Relaxed));
    assert_eq!(finished.stored, expected.finished("sum").unwrap().stored);
}

#[test]
fn an_interrupted_run_keeps_what_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let stop = StopFlag::default();
    let job = Arc::new(Harmonic { stop_after: Some((4, stop.clone())), ..Harmonic::new(5000) });
    let plan = Plan::new(vec![node("sum", job.clone()), following("next", &["sum"])]).unwrap();
    let summary = local::run(&plan, &cache, &settings(2), &stop, &Heard::default()).unwrap();
    assert!(summary.is_interrupted());
    assert_eq!(summary.failures(), 0);
    assert!(matches!(summary.outcomes["next"], Outcome::Interrupted));
    let run_before = job.blocks_run.load(Ordering::Relaxed);
    assert!((4..=5).contains(&run_before), "running blocks end, no other begins: {run_before}");

    let job = Arc::new(Harmonic::new(5000));
    let plan = Plan::new(vec![node("sum", job), following("next", &["sum"])]).unwrap();
    let summary = run(&plan, &cache, 2);
    assert_eq!(summary.finished("sum").unwrap().blocks_cached, run_before);
    assert!(summary.finished("next").is_some());
}

/// Blocks of which the last ones go on until they are asked to stop; the first one that ends asks.
struct Endless {
    stop: StopFlag,
    goes_on: bool,
}

impl Job for Endless {
    type State = ();
    type Input = u8;
    type Partial = u8;
    type Output = serde_json::Value;
    fn kind(&self) -> &'static str {
        "endless"
    }
    fn algorithm_version(&self) -> u32 {
        1
    }
    fn identity(&self) -> serde_json::Value {
        serde_json::json!({})
    }
    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "wait".into(), state: (), inputs: (0..4).collect() })
    }
    fn block(&self, (): &(), input: u8, _parts: &dyn Parts) -> Result<u8, JobError> {
        if self.goes_on && input > 0 {
            loop {
                bmv::watch::check();
                std::thread::yield_now();
            }
        }
        if self.goes_on {
            self.stop.stop();
        }
        Ok(input)
    }
    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let outputs: Vec<u8> = blocks.into_iter().map(|(_, output)| output).collect();
        Ok(Step::Done(Box::new(serde_json::json!({ "blocks": outputs }))))
    }
}

#[test]
fn a_block_that_is_left_when_the_run_is_stopped_is_not_kept_and_no_failure() {
    for threads in [1, 2, 4] {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let stop = StopFlag::default();
        let plan = |goes_on| {
            let job = Arc::new(Endless { stop: stop.clone(), goes_on });
            Plan::new(vec![node("endless", job)]).unwrap()
        };
        let summary = local::run(&plan(true), &cache, &settings(threads), &stop, &Heard::default()).unwrap();
        assert!(matches!(summary.outcomes["endless"], Outcome::Interrupted), "{summary:?}");
        assert_eq!(summary.failures(), 0);
        assert_eq!(cache.statistics().unwrap().blocks, 1, "the one that had ended");
        let summary = run(&plan(false), &cache, threads);
        assert_eq!(summary.finished("endless").unwrap().stored.value["blocks"], serde_json::json!([0, 1, 2, 3]));
    }
}

/// Blocks of ten steps, each of which is kept; counts the steps that are done, and asks to stop after so many.
struct Stepwise {
    stop_after: Option<(usize, StopFlag)>,
    steps: AtomicUsize,
    /// Added to the states, as a job that is not reproducible would.
    wrong: u8,
}

impl Job for Stepwise {
    type State = ();
    type Input = Vec<u8>;
    type Partial = Vec<u8>;
    type Output = serde_json::Value;
    fn kind(&self) -> &'static str {
        "stepwise"
    }
    fn algorithm_version(&self) -> u32 {
        1
    }
    fn identity(&self) -> serde_json::Value {
        serde_json::json!({})
    }
    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "walk".into(), state: (), inputs: vec![vec![1], vec![2]] })
    }
    fn block(&self, (): &(), input: Vec<u8>, parts: &dyn Parts) -> Result<Vec<u8>, JobError> {
        let found = (1..10).rev().find_map(|part| Some((part, parts.find(part)?)));
        let (first, mut state) = found.unwrap_or((0, input));
        for part in first + 1..=10 {
            bmv::watch::check();
            let steps = self.steps.fetch_add(1, Ordering::Relaxed) + 1;
            state.push(part as u8 + self.wrong);
            if part < 10 && parts.is_due() {
                parts.keep(part, &state);
            }
            if let Some((_, stop)) = self.stop_after.as_ref().filter(|(count, _)| steps == *count) {
                stop.stop();
            }
        }
        Ok(state)
    }
    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let outputs: Vec<Vec<u8>> = blocks.into_iter().map(|(_, output)| output).collect();
        Ok(Step::Done(Box::new(serde_json::json!({ "all": outputs }))))
    }
}

#[test]
fn a_long_block_goes_on_from_the_last_state_that_it_left() {
    let start = |stop_after, wrong| Arc::new(Stepwise { stop_after, steps: AtomicUsize::new(0), wrong });
    let plan = |job: &Arc<Stepwise>| {
        let job: Arc<dyn Runnable> = Arc::clone(job) as Arc<dyn Runnable>;
        Plan::new(vec![node("walk", job)]).unwrap()
    };
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let short = Settings { keep_every: Some(Duration::MAX), ..settings(1) };
    let whole = local::run(&plan(&start(None, 0)), &cache, &short, &StopFlag::default(), &Heard::default()).unwrap();
    assert_eq!(cache.statistics().unwrap().blocks, 2, "short blocks leave no states");
    let whole = whole.finished("walk").unwrap().stored.sha256.clone();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let stop = StopFlag::default();
    let stopped = start(Some((7, stop.clone())), 0);
    let summary = local::run(&plan(&stopped), &cache, &settings(1), &stop, &Heard::default()).unwrap();
    assert!(matches!(summary.outcomes["walk"], Outcome::Interrupted), "{summary:?}");
    assert_eq!(cache.statistics().unwrap().blocks, 7, "the states of the block that was left");
    let again = start(None, 0);
    let summary = run(&plan(&again), &cache, 1);
    assert_eq!(summary.finished("walk").unwrap().stored.sha256, whole);
    assert_eq!(again.steps.load(Ordering::Relaxed), 20 - 7, "nothing that was kept is run again");
    // Run again on purpose, all is done and held against what was kept.
    let forced = |job: &Arc<Stepwise>| {
        let settings = Settings { force: true, ..settings(1) };
        let outcome = local::run(&plan(job), &cache, &settings, &StopFlag::default(), &Heard::default()).unwrap();
        (outcome, job.steps.load(Ordering::Relaxed))
    };
    let (summary, steps) = forced(&start(None, 0));
    assert!(summary.finished("walk").is_some() && steps == 20, "{summary:?}");
    let (summary, _) = forced(&start(None, 1));
    let Outcome::Failed(error) = &summary.outcomes["walk"] else { panic!("{summary:?}") };
    assert!(matches!(**error, RunnerError::Nondeterministic { .. }), "{error}");
}

#[test]
fn a_panic_names_job_stage_and_block_for_any_number_of_threads() {
    for threads in [1, 2, 7] {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let job = Arc::new(Harmonic { fault: Fault::PanicInBlocks, ..Harmonic::new(2000) });
        let summary = run(&single(&job), &cache, threads);
        let Outcome::Failed(error) = &summary.outcomes["sum"] else { panic!("{summary:?}") };
        assert_eq!(error.to_string(), "job `sum`, stage `coarse`, block 3: panicked: term 300 is too large");
    }
}

#[test]
fn a_failure_stops_what_builds_upon_it_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let heard = Heard::default();
    let plan = Plan::new(vec![
        node("bad", Arc::new(Harmonic { fault: Fault::FailInReduce, ..Harmonic::new(200) })),
        node("good", Arc::new(Harmonic::new(200))),
        following("second", &["good", "bad"]),
        following("third", &["second"]),
        following("fine", &["good"]),
    ])
    .unwrap();
    // `bad` and `good` have the same definition, so the same blocks; names keep them apart.
    let summary = local::run(&plan, &cache, &settings(2), &StopFlag::default(), &heard).unwrap();
    let Outcome::Failed(error) = &summary.outcomes["bad"] else { panic!("{summary:?}") };
    assert_eq!(error.to_string(), "job `bad`, stage `coarse`: the sum does not converge");
    assert!(summary.finished("good").is_some() && summary.finished("fine").is_some());
    assert!(matches!(&summary.outcomes["second"], Outcome::Skipped { upstream } if upstream == "bad"));
    assert!(matches!(&summary.outcomes["third"], Outcome::Skipped { upstream } if upstream == "second"));
    let heard = heard.0.into_inner().unwrap();
    assert_eq!(heard[0], Event::RunStarted { to_run: 5, cached: 0, threads: 2, engine: None });
    assert_eq!(heard[heard.len() - 1], Event::RunFinished { finished: 2, failed: 3, interrupted: false });
}

#[test]
fn upstream_results_that_do_not_fit_are_an_error_of_the_job() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let plan = Plan::new(vec![node("a", Arc::new(Harmonic::new(100))), following("b", &["a"])]).unwrap();
    // A result that another program put under the right key.
    cache.put(Kind::Result, &plan.keys()[0], &plan.keys()[0], b"{}").unwrap();
    let summary = run(&plan, &cache, 1);
    let Outcome::Failed(error) = &summary.outcomes["b"] else { panic!("{summary:?}") };
    assert_eq!(error.to_string(), "job `b`: upstream without `blocks`");
}

#[test]
fn a_job_that_is_not_reproducible_is_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic { fault: Fault::Counts, ..Harmonic::new(100) });
    assert_eq!(run(&single(&job), &cache, 1).failures(), 0);
    let forced = Settings { force: true, ..settings(1) };
    let summary = local::run(&single(&job), &cache, &forced, &StopFlag::default(), &Heard::default()).unwrap();
    let Outcome::Failed(error) = &summary.outcomes["sum"] else { panic!("{summary:?}") };
    assert!(matches!(**error, RunnerError::Nondeterministic { .. }), "{error}");
    assert_eq!(cache.statistics().unwrap().conflicts, 1, "both versions are kept");
}

#[test]
fn equal_jobs_run_once() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let jobs = [Arc::new(Harmonic::new(1000)), Arc::new(Harmonic::new(1000))];
    let mut nodes = vec![node("pass-1:sum", jobs[0].clone()), node("pass-2:sum", jobs[1].clone())];
    for node in &mut nodes {
        node.name = "sum".into();
    }
    let summary = run(&Plan::new(nodes).unwrap(), &cache, 2);
    let [first, second] = ["pass-1:sum", "pass-2:sum"].map(|id| summary.finished(id).unwrap());
    assert_eq!(first.stored, second.stored);
    assert!(!first.cached && second.cached);
    assert_eq!(jobs[1].blocks_run.load(Ordering::Relaxed), 0);
}

#[test]
fn a_raised_algorithm_version_runs_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    run(&single(&Arc::new(Harmonic::new(500))), &cache, 1);
    let raised = Arc::new(Harmonic { version: 1, ..Harmonic::new(500) });
    let summary = run(&single(&raised), &cache, 1);
    let finished = summary.finished("sum").unwrap();
    assert_eq!((finished.cached, finished.blocks_cached), (false, 0));
}
