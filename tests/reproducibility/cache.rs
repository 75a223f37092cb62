//! The cache below the engine: damage, several runners at once, disks that refuse.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bmv::runner::engine::local;
use bmv::runner::{Cache, Event, StopFlag};

use super::toy::{Harmonic, Heard, run, settings, single};

#[test]
fn a_damaged_result_is_set_aside_and_made_again_from_its_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic::new(1000));
    let plan = single(&job);
    let before = run(&plan, &cache, 2);
    let blocks = job.blocks_run.load(Ordering::Relaxed);

    let path = cache.path(&plan.keys()[0]);
    let mut bytes = fs::read(&path).unwrap();
    bytes[5] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let heard = Heard::default();
    let after = local::run(&plan, &cache, &settings(2), &StopFlag::default(), &heard).unwrap();
    assert_eq!(after.finished("sum").unwrap().stored, before.finished("sum").unwrap().stored);
    assert_eq!(job.blocks_run.load(Ordering::Relaxed), blocks, "the blocks are there");
    assert_eq!(heard.0.lock().unwrap()[0], Event::Damaged { object: plan.keys()[0].clone() });
    assert_eq!(cache.statistics().unwrap().quarantined, 1);
}

#[test]
fn torn_and_zeroed_blocks_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic::new(1000));
    let plan = single(&job);
    let before = run(&plan, &cache, 1);
    let blocks = job.blocks_run.load(Ordering::Relaxed);
    let result = cache.path(&plan.keys()[0]);
    fs::remove_file(&result).unwrap();
    // A disk that lost its power: some files are cut, some hold zeros of the right length.
    let objects = walkdir::WalkDir::new(folder.path().join("objects")).sort_by_file_name();
    let files: Vec<_> = objects.into_iter().flatten().filter(|entry| entry.file_type().is_file()).collect();
    assert_eq!(files.len(), blocks);
    fs::write(files[0].path(), b"").unwrap();
    let length = fs::metadata(files[1].path()).unwrap().len() as usize;
    fs::write(files[1].path(), vec![0; length]).unwrap();

    let after = run(&plan, &cache, 1);
    assert_eq!(after.finished("sum").unwrap().stored, before.finished("sum").unwrap().stored);
    assert_eq!(job.blocks_run.load(Ordering::Relaxed), blocks + 2);
}

#[test]
fn two_runners_on_one_cache_agree_and_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let results: Vec<_> = std::thread::scope(|scope| {
        let runners: Vec<_> = (0..3)
            .map(|threads| {
                let root = folder.path();
                scope.spawn(move || {
                    let summary = run(&single(&Arc::new(Harmonic::new(4000))), &Cache::new(root), threads + 1);
                    summary.finished("sum").cloned().expect("finished").stored
                })
            })
            .collect();
        runners.into_iter().map(|runner| runner.join().unwrap()).collect()
    });
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
    let cache = Cache::new(folder.path());
    let statistics = cache.statistics().unwrap();
    assert_eq!((statistics.results, statistics.leftovers), (1, 0));
    assert_eq!((statistics.quarantined, statistics.conflicts), (0, 0));
    assert!(cache.verify().unwrap().damaged.is_empty());
}

#[test]
fn what_stays_after_pruning_is_still_a_cached_result() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let job = Arc::new(Harmonic::new(1000));
    let plan = single(&job);
    run(&plan, &cache, 1);
    let blocks = job.blocks_run.load(Ordering::Relaxed);
    cache.prune(&plan.keys().iter().cloned().collect()).unwrap();
    assert_eq!(cache.statistics().unwrap().blocks, 0);
    assert!(run(&plan, &cache, 1).finished("sum").unwrap().cached);
    assert_eq!(job.blocks_run.load(Ordering::Relaxed), blocks);
}

#[test]
fn what_cannot_be_stored_is_used_and_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("cache");
    fs::write(&root, "a file where the folder should be").unwrap();
    let heard = Heard::default();
    let (plan, stop) = (single(&Arc::new(Harmonic::new(1000))), StopFlag::default());
    let summary = local::run(&plan, &Cache::new(&root), &settings(2), &stop, &heard).unwrap();
    let stored = run(&plan, &Cache::new(folder.path().join("other")), 1);
    assert_eq!(summary.finished("sum").unwrap().stored, stored.finished("sum").unwrap().stored);
    let heard = heard.0.lock().unwrap();
    let reported: Vec<_> = heard.iter().filter(|event| matches!(event, Event::NotStored { .. })).collect();
    let [Event::NotStored { reason }] = reported.as_slice() else { panic!("{reported:?}") };
    assert!(reason.starts_with("cannot make the folder `") && reason.contains("cache/objects"), "{reason}");
}
