//! Tests of `src/batch/live/changes.rs`.

use std::path::PathBuf;

use bmv::batch::live::changes::*;

/// A study's folder with a model, a pass, data in folders that are hidden or of a build, and notes that nothing reads.
fn study() -> tempfile::TempDir {
    let root = tempfile::tempdir().expect("a folder");
    for folder in ["target", ".logger", "effects"] {
        std::fs::create_dir(root.path().join(folder)).expect("made");
    }
    for name in ["model.json", "pass-1.json", "target/a.csv", ".logger/b.csv", "notes.txt"] {
        std::fs::write(root.path().join(name), "1").expect("written");
    }
    root
}

#[test]
fn what_is_read_is_seen_wherever_it_lies_and_nothing_else() {
    let root = study();
    let write = |name: &str, text: &str| std::fs::write(root.path().join(name), text).expect("written");
    let watched = Watched::new(root.path());
    assert!(!watched.has_changed());
    write("target/a.csv", "12");
    assert!(!watched.has_changed(), "before anything is read");
    let read = ["model.json", "pass-1.json", "target/a.csv", ".logger/b.csv", "data/late.csv"];
    watched.look(Looked { read: read.map(PathBuf::from).into(), all: false });
    assert!(!watched.has_changed());
    for unread in ["notes.txt", "other.json", "target/other.csv", "effects/notes.md", "pass-1.json~"] {
        write(unread, "changed");
        assert!(!watched.has_changed(), "{unread} is not read");
    }
    std::fs::create_dir(root.path().join("data")).expect("made");
    for seen in ["target/a.csv", ".logger/b.csv", "data/late.csv", "pass-2.json", "effects/own.json", "model.json"] {
        write(seen, "changed");
        assert_eq!(watched.renew(), [seen]);
        assert!(!watched.has_changed());
    }
    std::fs::remove_file(root.path().join("target/a.csv")).expect("removed");
    assert_eq!(watched.renew(), ["target/a.csv"]);
}

#[test]
fn a_change_while_the_files_are_read_is_not_lost() {
    let root = study();
    let watched = Watched::new(root.path());
    std::fs::write(root.path().join("model.json"), "changed").expect("written");
    watched.look(Looked { read: [PathBuf::from("model.json")].into(), all: false });
    assert_eq!(watched.renew(), ["model.json"]);
    std::fs::write(root.path().join("notes.txt"), "changed").expect("written");
    watched.widen();
    assert!(!watched.has_changed());
    std::fs::write(root.path().join("notes.txt"), "changed again").expect("written");
    assert_eq!(watched.renew(), ["notes.txt"], "what is wrong may be cured by any file");
}
