//! Tests of `src/study/file.rs`.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use bmv::study::file::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn names(folder: &Path) -> usize {
    fs::read_dir(folder).expect("listed").count()
}

#[test]
fn a_file_is_kept_or_replaced_and_no_draft_stays() {
    let root = folder();
    let place = Path::new("deep/er/file.txt");
    write(root.path(), place, b"one", Existing::Keep).expect("written");
    let again = write(root.path(), place, b"two", Existing::Keep).expect_err("it is there");
    assert_eq!(again.kind(), ErrorKind::AlreadyExists);
    assert_eq!(fs::read(root.path().join(place)).expect("read"), b"one");
    write(root.path(), place, b"two", Existing::Replace).expect("replaced");
    assert_eq!(fs::read(root.path().join(place)).expect("read"), b"two");
    assert_eq!(names(&root.path().join("deep/er")), 1);
    for path in ["../x", "/tmp/x", "a/../../x", ""] {
        assert!(write(root.path(), Path::new(path), b"x", Existing::Replace).is_err(), "{path}");
    }
}

#[cfg(unix)]
#[test]
fn nothing_is_written_or_removed_through_a_link() {
    use std::os::unix::fs::symlink;
    let (root, outside) = (folder(), folder());
    let foreign = outside.path().join("foreign");
    fs::write(&foreign, "foreign").expect("written");
    symlink(outside.path(), root.path().join("out")).expect("linked");
    symlink(&foreign, root.path().join("file")).expect("linked");
    symlink("nowhere", root.path().join("dangling")).expect("linked");
    for path in ["out/foreign", "out/new/deep", "file", "dangling"] {
        for existing in [Existing::Keep, Existing::Replace] {
            assert!(write(root.path(), Path::new(path), b"mine", existing).is_err(), "{path}");
        }
    }
    for path in ["out/foreign", "file", "nothing/here"] {
        remove(root.path(), Path::new(path)).expect("left alone");
    }
    assert_eq!((fs::read(&foreign).expect("there"), names(outside.path())), (b"foreign".to_vec(), 1));
    assert_eq!(names(root.path()), 3, "no draft stays");
    assert_eq!(read(&root.path().join("file"), 10).expect_err("a link").kind(), ErrorKind::InvalidData);
    // The base itself is the user's choice.
    write(&root.path().join("out"), Path::new("new"), b"mine", Existing::Keep).expect("written");
    remove(&root.path().join("out"), Path::new("new")).expect("removed");
    assert_eq!(names(outside.path()), 1);
}

#[test]
fn only_regular_files_of_bounded_size_are_read() {
    let root = folder();
    fs::write(root.path().join("file"), "12345").expect("written");
    assert_eq!(read(&root.path().join("file"), 5).expect("read"), b"12345");
    for (path, limit) in [("file", 4), ("", 10)] {
        assert_eq!(read(&root.path().join(path), limit).expect_err("refused").kind(), ErrorKind::InvalidData);
    }
    if Path::new("/dev/zero").exists() {
        assert_eq!(read(Path::new("/dev/zero"), 10).expect_err("refused").kind(), ErrorKind::InvalidData);
    }
    assert_eq!(read(&root.path().join("nothing"), 10).expect_err("not there").kind(), ErrorKind::NotFound);
}
