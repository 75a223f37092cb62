//! Whole processes: killed, interrupted, two on one cache. The process is this test binary, run with [`child`] alone.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bmv::job::{Done, Job, JobError, Parts, Step};
use bmv::runner::engine::local;
use bmv::runner::interrupt::Interrupts;
use bmv::runner::{Cache, Plan};
use serde_json::{Value, json};

use super::toy::{Heard, node, run, settings};

const BLOCKS: usize = 400;
const FOLDER: &str = "BMV_TEST_CACHE";

/// Blocks that take two milliseconds each.
struct Slow;

impl Job for Slow {
    type State = ();
    type Input = usize;
    type Partial = usize;
    type Output = Value;
    fn kind(&self) -> &'static str {
        "slow"
    }
    fn algorithm_version(&self) -> u32 {
        1
    }
    fn identity(&self) -> Value {
        json!({ "blocks": BLOCKS })
    }
    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "wait".into(), state: (), inputs: (0..BLOCKS).collect() })
    }
    fn block(&self, (): &(), input: usize, _parts: &dyn Parts) -> Result<usize, JobError> {
        std::thread::sleep(Duration::from_millis(2));
        Ok(input)
    }
    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let joined: Vec<String> = blocks.iter().map(|(_, output)| output.to_string()).collect();
        Ok(Step::Done(Box::new(json!({ "joined": joined.concat() }))))
    }
}

fn plan() -> Plan {
    Plan::new(vec![node("slow", Arc::new(Slow))]).expect("one job")
}

/// Not a test: what the other process does.
#[test]
#[ignore = "run by the tests of this file"]
fn child() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let interrupts = Interrupts::catch(130).unwrap();
    let cache = Cache::new(folder);
    let run = |stop: &_| local::run(&plan(), &cache, &settings(2), stop, &Heard::default());
    let summary = interrupts.during(run).unwrap();
    std::process::exit(if summary.is_interrupted() { 130 } else { 0 });
}

fn start(folder: &Path) -> Child {
    Command::new(std::env::current_exe().expect("this binary"))
        .args(["--exact", "reproducibility::process::child", "--ignored"])
        .env(FOLDER, folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts")
}

/// Waits until so many blocks are stored, or ten seconds.
fn wait_for_blocks(cache: &Cache, count: u64) {
    let begin = Instant::now();
    while cache.statistics().expect("readable").blocks < count && begin.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Runs what is missing here; gives the blocks that were found.
fn finish(cache: &Cache) -> usize {
    let summary = run(&plan(), cache, 2);
    let finished = summary.finished("slow").expect("finished");
    let expected: String = (0..BLOCKS).map(|index| index.to_string()).collect();
    assert_eq!(finished.stored.value["joined"], expected);
    assert_eq!(finished.blocks_run + finished.blocks_cached, BLOCKS);
    let statistics = cache.statistics().expect("readable");
    assert_eq!((statistics.quarantined, statistics.conflicts), (0, 0));
    finished.blocks_cached
}

#[test]
fn a_killed_process_leaves_whole_blocks_and_the_next_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    for blocks in [10, 40, 70] {
        let mut process = start(folder.path());
        wait_for_blocks(&cache, blocks);
        process.kill().unwrap();
        assert!(!process.wait().unwrap().success());
    }
    assert!(cache.verify().unwrap().damaged.is_empty());
    let found = finish(&cache);
    assert!((70..BLOCKS).contains(&found), "{found}");
}

#[test]
#[ignore = "thorough"]
fn an_interrupted_process_ends_with_130_and_keeps_its_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let mut process = start(folder.path());
    wait_for_blocks(&cache, 20);
    assert!(Command::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap().success());
    assert_eq!(process.wait().unwrap().code(), Some(130));
    assert_eq!(cache.statistics().unwrap().leftovers, 0);
    let found = finish(&cache);
    assert!((20..BLOCKS).contains(&found), "{found}");
}

#[test]
#[ignore = "thorough"]
fn two_processes_share_a_cache() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let mut processes = [start(folder.path()), start(folder.path())];
    for process in &mut processes {
        assert!(process.wait().unwrap().success());
    }
    let statistics = cache.statistics().unwrap();
    assert_eq!((statistics.results, statistics.blocks), (1, BLOCKS as u64));
    assert_eq!((statistics.leftovers, statistics.quarantined, statistics.conflicts), (0, 0, 0));
    assert!(cache.verify().unwrap().damaged.is_empty());
    assert!(run(&plan(), &cache, 1).finished("slow").unwrap().cached);
}
