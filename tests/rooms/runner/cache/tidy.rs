//! Tests of `src/runner/cache/tidy.rs`.

use std::collections::BTreeSet;
use std::fs;

use bmv::runner::cache::tidy::*;
use bmv::runner::cache::{Cache, Kind, Lookup};
use bmv::runner::key::Key;

fn filled() -> (tempfile::TempDir, Cache, Key, Key) {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let (finished, running) = (Key::of(b"finished"), Key::of(b"running"));
    cache.put(Kind::Result, &finished, &finished, b"{}").unwrap();
    cache.put(Kind::Block, &finished, &Key::of(b"block 1"), b"1").unwrap();
    cache.put(Kind::Block, &running, &Key::of(b"block 2"), b"2").unwrap();
    (folder, cache, finished, running)
}

#[test]
fn statistics_count_by_kind() {
    let (_folder, cache, ..) = filled();
    let statistics = cache.statistics().unwrap();
    assert_eq!((statistics.results, statistics.blocks, statistics.leftovers), (1, 2, 0));
    assert!(statistics.block_bytes > statistics.result_bytes);
    assert_eq!(Cache::new("/nonexistent/cache").statistics().unwrap(), Statistics::default());
}

#[test]
fn verification_sets_damaged_objects_aside() {
    let (_folder, cache, finished, _) = filled();
    assert_eq!(cache.verify().unwrap(), Verified { sound: 3, damaged: Vec::new() });
    fs::write(cache.path(&finished), b"{]").unwrap();
    assert_eq!(cache.verify().unwrap(), Verified { sound: 2, damaged: vec![finished.to_string()] });
    assert_eq!(cache.statistics().unwrap().quarantined, 1);
    assert_eq!(cache.verify().unwrap().sound, 2);
}

#[test]
fn pruning_keeps_results_and_blocks_of_unfinished_jobs_that_are_asked_for() {
    let (_folder, cache, finished, running) = filled();
    let pruned = cache.prune(&[finished.clone(), running.clone()].into()).unwrap();
    assert_eq!((pruned.kept, pruned.moved), (2, 1), "the finished job's block goes");
    assert_eq!(cache.get(Kind::Result, &finished), Lookup::Found(b"{}".to_vec()));
    assert_eq!(cache.get(Kind::Block, &Key::of(b"block 2")), Lookup::Found(b"2".to_vec()));
    let pruned = cache.prune(&BTreeSet::new()).unwrap();
    assert_eq!((pruned.kept, pruned.moved, pruned.deleted), (0, 2, 0));
    assert_eq!(cache.statistics().unwrap().trashed, 3);
}

#[test]
fn the_trash_is_emptied_after_a_day() {
    let (_folder, cache, ..) = filled();
    let yesterday = seconds_since_1970() - KEPT_FOR.as_secs() - 1;
    let old = cache.root().join("trash").join(yesterday.to_string());
    fs::create_dir_all(&old).unwrap();
    fs::write(old.join("object"), b"x").unwrap();
    assert_eq!(cache.prune(&BTreeSet::new()).unwrap().deleted, 1);
    assert!(!old.exists());
}

#[test]
fn leftovers_of_dead_processes_go_and_those_of_live_ones_stay() {
    let folder = tempfile::tempdir().unwrap();
    let host = host();
    // Process numbers on Linux are below 2^22.
    let dead = folder.path().join(format!("{TEMPORARY}{host}-4194305-0-0"));
    let alive = folder.path().join(format!("{TEMPORARY}{}-0-0", writer_prefix()));
    let elsewhere = folder.path().join(format!("{TEMPORARY}another-4194305-0-0"));
    for path in [&dead, &alive, &elsewhere] {
        fs::write(path, b"half").unwrap();
    }
    assert_eq!(remove_leftovers(folder.path()), 1);
    assert!(!dead.exists() && alive.exists() && elsewhere.exists());
}
