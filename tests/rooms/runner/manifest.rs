//! Tests of `src/runner/manifest.rs`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use bmv::runner::error::RunnerError;
use bmv::runner::key::Key;
use bmv::runner::manifest::*;

fn report() -> (tempfile::TempDir, Manifest) {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir_all(root.path().join("reports/plots")).unwrap();
    fs::write(root.path().join("model.json"), "{}").unwrap();
    let mut manifest = Manifest::new("bmv report studies/x");
    manifest.add_input("model.json", FileRecord::of(b"{}"));
    for (name, text) in [("report.md", "# Report"), ("plots/a.svg", "<svg/>")] {
        fs::write(root.path().join("reports").join(name), text).unwrap();
        manifest.add_output(name, text.as_bytes());
    }
    manifest.write(root.path(), Path::new("reports")).unwrap();
    (root, manifest)
}

fn verify(root: &Path) -> Verification {
    let folder = root.join("reports");
    Manifest::read(&folder).unwrap().verify(&folder, root).unwrap()
}

#[test]
fn a_fresh_report_is_intact() {
    let (root, manifest) = report();
    assert_eq!(Manifest::read(&root.path().join("reports")).unwrap(), manifest);
    assert_eq!(manifest.outputs.keys().collect::<Vec<_>>(), ["plots/a.svg", "report.md"]);
    let verification = verify(root.path());
    assert!(verification.is_intact());
    assert_eq!(verification, Verification { unchanged: 3, ..Verification::default() });
}

#[test]
fn changed_missing_and_extra_files_are_found() {
    let (root, _) = report();
    fs::write(root.path().join("reports/report.md"), "# Rep0rt").unwrap();
    fs::remove_file(root.path().join("reports/plots/a.svg")).unwrap();
    fs::write(root.path().join("reports/plots/b.svg"), "<svg/>").unwrap();
    fs::write(root.path().join("model.json"), "{ }").unwrap();
    let verification = verify(root.path());
    assert!(!verification.is_intact());
    assert_eq!(verification.changed, ["report.md"]);
    assert_eq!(verification.missing, ["plots/a.svg"]);
    assert_eq!(verification.extra, ["plots/b.svg"]);
    assert_eq!(verification.changed_inputs, ["model.json"]);
    assert_eq!(verification.unchanged, 0);
}

#[test]
fn missing_data_are_reported_and_leave_the_report_intact() {
    let (root, _) = report();
    fs::remove_file(root.path().join("model.json")).unwrap();
    let verification = verify(root.path());
    assert_eq!(verification.missing_inputs, ["model.json"]);
    assert!(verification.is_intact());
}

#[test]
fn paths_that_leave_the_folder_are_refused() {
    let (root, mut manifest) = report();
    let folder = root.path().join("reports");
    for name in ["../model.json", "/etc/passwd", "plots/../../model.json", ""] {
        let record = FileRecord { bytes: 2, sha256: Key::of(b"{}") };
        manifest.outputs = BTreeMap::from([(name.to_owned(), record)]);
        manifest.write(&folder, Path::new("")).unwrap();
        let error = Manifest::read(&folder).unwrap_err().to_string();
        assert!(error.contains("leaves the folder"), "{name}: {error}");
    }
}

#[test]
fn what_is_no_manifest_is_an_error() {
    let root = tempfile::tempdir().unwrap();
    assert!(matches!(Manifest::read(root.path()), Err(RunnerError::File { .. })));
    for text in ["", "{}", "[1", r#"{"format": "x/1"}"#] {
        fs::write(root.path().join(FILE_NAME), text).unwrap();
        assert!(matches!(Manifest::read(root.path()), Err(RunnerError::Manifest { .. })), "{text}");
    }
}

#[test]
fn two_writings_give_the_same_bytes() {
    let (root, manifest) = report();
    let path = root.path().join("reports").join(FILE_NAME);
    let first = fs::read(&path).unwrap();
    manifest.write(root.path(), Path::new("reports")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), first);
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_has_changed_and_nothing_waits_for_it() {
    let (root, manifest) = report();
    let folder = root.path().join("reports");
    fs::remove_file(root.path().join("model.json")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", root.path().join("model.json")).unwrap();
    let pipe = folder.join("report.md");
    fs::remove_file(&pipe).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    fs::copy(folder.join("plots/a.svg"), root.path().join("a.svg")).unwrap();
    fs::remove_file(folder.join("plots/a.svg")).unwrap();
    std::os::unix::fs::symlink("../../a.svg", folder.join("plots/a.svg")).unwrap();
    let verification = verify(root.path());
    assert_eq!(verification.changed, ["plots/a.svg", "report.md"]);
    assert_eq!(verification.changed_inputs, ["model.json"]);
    fs::remove_file(folder.join(FILE_NAME)).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(folder.join(FILE_NAME)).status().unwrap().success());
    assert!(Manifest::read(&folder).unwrap_err().to_string().contains("is no regular file"));
    assert!(manifest.write(root.path(), Path::new("reports")).is_err(), "nor is one replaced");
}

#[test]
fn the_origin_is_all_but_the_outputs() {
    let (_root, manifest) = report();
    let mut other = manifest.clone();
    other.add_output("report.html", b"<html>");
    assert_eq!(other.origin_sha256().unwrap(), manifest.origin_sha256().unwrap());
    other.add_input("model.json", FileRecord::of(b"{ }"));
    assert_ne!(other.origin_sha256().unwrap(), manifest.origin_sha256().unwrap());
}
