//! Tests of `src/study/folder.rs`.

use std::collections::BTreeMap;

use bmv::document::json;
use bmv::study::folder::*;
use bmv::study::ledger::Content;

#[test]
fn paths_stay_inside() {
    let outside = tempfile::tempdir().expect("a folder");
    std::fs::write(outside.path().join("secret"), "x").expect("written");
    let inside = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(inside.path().join("data")).expect("made");
    std::fs::write(inside.path().join("data/a.csv"), "x").expect("written");
    let folder = Folder::open(inside.path()).expect("opened");
    assert_eq!(folder.read("data/a.csv").expect("read"), b"x");
    assert_eq!(folder.read("./data/a.csv").expect("read"), b"x");
    let absolute = outside.path().join("secret").display().to_string();
    for path in ["../x", "data/../../x", "..", "", ".", "/etc/passwd", &absolute, "data\\a.csv", "a\0b"] {
        assert!(matches!(folder.read(path), Err(FolderError::NotPlain { .. })), "{path}");
    }
    assert!(matches!(folder.read("data/b.csv"), Err(FolderError::Missing { .. })));
    assert!(matches!(folder.read("data"), Err(FolderError::Unreadable { .. })));
    assert!(folder.place("new/deep/file.csv").is_ok());
    assert!(folder.has_file("data/a.csv") && !folder.has_file("data") && !folder.has_file("../x"));
}

#[test]
fn a_file_is_refused_by_its_size_before_it_is_read() {
    let inside = tempfile::tempdir().expect("a folder");
    // Without blocks on the disk: reading it whole would fill the memory.
    let sparse = std::fs::File::create(inside.path().join("a.csv")).expect("made");
    sparse.set_len(6 << 30).expect("sized");
    let folder = Folder::open(inside.path()).expect("opened");
    let limits = [(folder.read("a.csv"), json::SIZE), (folder.read_table("a.csv"), TABLE_SIZE)];
    for (read, most) in limits {
        assert!(matches!(read, Err(FolderError::TooLarge { limit, bytes, .. }) if limit == most && bytes == 6 << 30));
    }
    sparse.set_len(json::SIZE as u64 + 1).expect("sized");
    assert!(matches!(folder.read("a.csv"), Err(FolderError::TooLarge { .. })));
    assert_eq!(folder.read_table("a.csv").expect("read").len(), json::SIZE + 1);
}

#[cfg(unix)]
#[test]
fn what_is_no_plain_file_is_not_opened() {
    let inside = tempfile::tempdir().expect("a folder");
    let pipe = inside.path().join("pipe.json");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    let _socket = std::os::unix::net::UnixListener::bind(inside.path().join("socket.json")).expect("bound");
    let folder = Folder::open(inside.path()).expect("opened");
    for name in ["pipe.json", "socket.json"] {
        assert!(matches!(folder.read(name), Err(FolderError::Unreadable { .. })), "{name}");
    }
}

#[test]
fn what_was_read_is_noted_and_must_not_change() {
    let root = tempfile::tempdir().expect("a folder");
    std::fs::write(root.path().join("a.csv"), "x").expect("written");
    let folder = Folder::open(root.path()).expect("opened");
    for path in ["a.csv", "./a.csv"] {
        assert_eq!(folder.read(path).expect("read"), b"x");
    }
    std::fs::write(root.path().join("a.csv"), "y").expect("written");
    assert!(matches!(folder.read("a.csv"), Err(FolderError::Unreadable { .. })));
    assert_eq!(folder.files(), BTreeMap::from([("a.csv".to_owned(), Content::of(b"x"))]));
    let again = Folder::open(root.path()).expect("opened");
    assert_eq!(again.read("a.csv").expect("read"), b"y");
    assert!(again.after(folder.files()).read("a.csv").is_err(), "what was loaded is another");
}

#[cfg(unix)]
#[test]
fn links_may_not_lead_out() {
    let outside = tempfile::tempdir().expect("a folder");
    std::fs::write(outside.path().join("secret"), "x").expect("written");
    let inside = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(outside.path(), inside.path().join("out")).expect("linked");
    std::os::unix::fs::symlink("nowhere", inside.path().join("dangling")).expect("linked");
    std::fs::write(inside.path().join("a.csv"), "x").expect("written");
    std::os::unix::fs::symlink("a.csv", inside.path().join("b.csv")).expect("linked");
    let folder = Folder::open(inside.path()).expect("opened");
    assert!(matches!(folder.read("out/secret"), Err(FolderError::LeadsOut { .. })));
    assert!(matches!(folder.place("out/new"), Err(FolderError::LeadsOut { .. })));
    assert!(matches!(folder.place("dangling"), Err(FolderError::LeadsOut { .. })));
    assert_eq!(folder.read("b.csv").expect("read"), b"x");
}
