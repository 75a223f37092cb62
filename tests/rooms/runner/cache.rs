//! Tests of `src/runner/cache/mod.rs`.

mod object;
mod tidy;

use std::fs;
use std::fs::File;
use std::path::Path;

use bmv::runner::cache::object::Kind;
use bmv::runner::cache::tidy::Pruned;
use bmv::runner::cache::*;
use bmv::runner::error::RunnerError;
use bmv::runner::key::Key;

fn cache() -> (tempfile::TempDir, Cache) {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path().join("cache"));
    (folder, cache)
}

fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn what_is_stored_is_found_and_nothing_else_is_left() {
    let (_folder, cache) = cache();
    let name = Key::of(b"name");
    assert_eq!(cache.get(Kind::Result, &name), Lookup::Absent);
    cache.put(Kind::Result, &name, &name, b"payload").unwrap();
    cache.put(Kind::Result, &name, &name, b"payload").unwrap();
    assert_eq!(cache.get(Kind::Result, &name), Lookup::Found(b"payload".to_vec()));
    assert_eq!(names(cache.path(&name).parent().unwrap()).len(), 1, "no temporary file stays");
}

#[test]
fn other_bytes_for_one_name_are_an_error_that_keeps_both() {
    let (_folder, cache) = cache();
    let name = Key::of(b"name");
    cache.put(Kind::Block, &name, &name, b"first").unwrap();
    let error = cache.put(Kind::Block, &name, &name, b"second").unwrap_err();
    let RunnerError::Nondeterministic { stored, kept, .. } = &error else { panic!("{error}") };
    assert!(fs::read(stored).unwrap().starts_with(b"first\n"));
    assert!(fs::read(kept).unwrap().starts_with(b"second\n"));
    assert_eq!(cache.get(Kind::Block, &name), Lookup::Found(b"first".to_vec()));
}

#[test]
fn a_damaged_object_is_set_aside_on_reading_and_on_writing() {
    let (_folder, cache) = cache();
    let name = Key::of(b"name");
    cache.put(Kind::Block, &name, &name, b"payload").unwrap();
    fs::write(cache.path(&name), b"payl").unwrap();
    assert_eq!(cache.get(Kind::Block, &name), Lookup::Damaged);
    assert_eq!(cache.get(Kind::Block, &name), Lookup::Absent);
    fs::write(cache.path(&name), b"").unwrap();
    cache.put(Kind::Block, &name, &name, b"payload").unwrap();
    assert_eq!(cache.get(Kind::Block, &name), Lookup::Found(b"payload".to_vec()));
    assert_eq!(names(&cache.root().join("quarantine")).len(), 2);
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_set_aside_on_reading_and_on_writing() {
    let (folder, cache) = cache();
    let name = Key::of(b"name");
    let path = cache.path(&name);
    let pipe = |path: &Path| assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    let dangling = |path: &Path| std::os::unix::fs::symlink("nowhere", path).unwrap();
    let endless = |path: &Path| std::os::unix::fs::symlink("/dev/zero", path).unwrap();
    let directory = |path: &Path| fs::create_dir(path).unwrap();
    let sparse = |path: &Path| File::create(path).unwrap().set_len(LARGEST + 1).unwrap();
    let things: [&dyn Fn(&Path); 5] = [&pipe, &dangling, &endless, &directory, &sparse];
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    for thing in things {
        thing(&path);
        assert_eq!(cache.get(Kind::Result, &name), Lookup::Damaged);
        assert_eq!(cache.get(Kind::Result, &name), Lookup::Absent);
        thing(&path);
        cache.put(Kind::Result, &name, &name, b"payload").unwrap();
        assert_eq!(cache.get(Kind::Result, &name), Lookup::Found(b"payload".to_vec()));
        fs::remove_file(&path).unwrap();
    }
    assert_eq!(names(&cache.root().join("quarantine")).len(), 2 * things.len());
    // And where all objects are gone through.
    pipe(&path);
    assert_eq!(cache.statistics().unwrap().leftovers, 1);
    assert_eq!(cache.verify().unwrap().damaged, [name.to_string()]);
    pipe(&path);
    assert_eq!(cache.prune(&[name].into()).unwrap().moved, 1);
    drop(folder);
}

#[cfg(unix)]
#[test]
fn no_link_in_a_cache_is_followed() {
    let (_folder, cache) = cache();
    let outside = tempfile::tempdir().unwrap();
    let name = Key::of(b"name");
    fs::create_dir_all(cache.root().join("objects")).unwrap();
    let folder = cache.path(&name).parent().unwrap().to_owned();
    std::os::unix::fs::symlink(outside.path(), &folder).unwrap();
    let error = cache.put(Kind::Result, &name, &name, b"payload").unwrap_err().to_string();
    assert!(error.contains("is a link"), "{error}");
    let (_, file) = name.as_str().split_at(2);
    fs::write(outside.path().join(file), b"foreign").unwrap();
    assert_eq!(cache.prune(&Default::default()).unwrap(), Pruned::default());
    assert_eq!(names(outside.path()), [file]);
}

#[test]
fn many_writers_of_one_name_agree() {
    let (_folder, cache) = cache();
    let root = cache.root().to_path_buf();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            let root = root.clone();
            scope.spawn(move || {
                let cache = Cache::new(root);
                for i in 0..50_u8 {
                    let name = Key::of(&[i]);
                    cache.put(Kind::Block, &name, &name, &[i; 1000]).unwrap();
                }
            });
        }
    });
    for i in 0..50_u8 {
        assert_eq!(cache.get(Kind::Block, &Key::of(&[i])), Lookup::Found(vec![i; 1000]));
    }
    let statistics = cache.statistics().unwrap();
    assert_eq!((statistics.blocks, statistics.leftovers, statistics.quarantined), (50, 0, 0));
}

#[test]
fn a_cache_that_cannot_be_written_says_which_file() {
    let folder = tempfile::tempdir().unwrap();
    let in_the_way = folder.path().join("cache");
    fs::write(&in_the_way, "a file where the folder should be").unwrap();
    let cache = Cache::new(&in_the_way);
    let name = Key::of(b"name");
    assert_eq!(cache.get(Kind::Result, &name), Lookup::Absent);
    let error = cache.put(Kind::Result, &name, &name, b"payload").unwrap_err();
    assert!(error.to_string().starts_with("cannot make the folder `"), "{error}");
}
