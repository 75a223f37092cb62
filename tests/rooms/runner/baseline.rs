//! Tests of `src/runner/baseline.rs`.

use std::fs;
use std::path::Path;

use bmv::job::key_number::KeyNumber;
use bmv::runner::baseline::*;
use bmv::runner::key::Key;
use bmv::statistics::monte_carlo::StandardError;

fn baseline() -> Baseline {
    let error = StandardError::new(0.1 + 0.2, Some(1.0 / 3.0));
    let numbers =
        vec![KeyNumber::new("Gh", "mean", "W/K", 0.1 + 0.7, error), KeyNumber::new("x", "size", "", 2.0, None)];
    Baseline::new("first", None, ("calibrate", 9, 3), (2015, &Key::of(b"key")), &Key::of(b"result"), numbers)
}

#[test]
fn a_baseline_is_read_as_it_was_written() {
    let study = tempfile::tempdir().unwrap();
    let inside = path("pass-1.json", "before");
    assert_eq!(inside, Path::new("baseline/pass-1/before.json"));
    let there = study.path().join(&inside);
    assert_eq!(Baseline::read(&there).unwrap(), None);
    assert!(files(study.path(), "pass-1.json").unwrap().is_empty());
    baseline().write(study.path(), &inside).unwrap();
    assert_eq!(Baseline::read(&there).unwrap(), Some(baseline()));
    assert_eq!(files(study.path(), "pass-1.json").unwrap(), std::slice::from_ref(&there));
    let text = fs::read_to_string(&there).unwrap();
    assert!(
        text.contains("\n    {\"of\":\"x\",\"statistic\":\"size\",\"unit\":\"\",\"value\":2.0}\n  ]\n}\n"),
        "{text}"
    );
    let mut empty = baseline();
    (empty.numbers, empty.date) = (Vec::new(), Some("2026-01-02".into()));
    empty.write(study.path(), &inside).unwrap();
    assert_eq!(Baseline::read(&there).unwrap(), Some(empty));
}

#[test]
fn names_stay_inside_the_folder() {
    let path = path("pass-1.json", "../a/b:c");
    assert_eq!(path, Path::new("baseline/pass-1/%2E.%2Fa%2Fb%3Ac.json"));
}

#[cfg(unix)]
#[test]
fn a_baseline_does_not_lead_out_and_is_not_waited_for() {
    let (study, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let foreign = outside.path().join("before.json");
    fs::write(&foreign, "foreign").unwrap();
    fs::create_dir(study.path().join("baseline")).unwrap();
    std::os::unix::fs::symlink(outside.path(), study.path().join("baseline/pass-1")).unwrap();
    fs::create_dir(study.path().join("baseline/pass-2")).unwrap();
    std::os::unix::fs::symlink(&foreign, study.path().join("baseline/pass-2/before.json")).unwrap();
    for pass in ["pass-1.json", "pass-2.json"] {
        let error = baseline().write(study.path(), &path(pass, "before")).unwrap_err().to_string();
        assert!(error.contains("is a link, and nothing is written through links"), "{error}");
    }
    assert_eq!(fs::read(&foreign).unwrap(), b"foreign");
    let pipe = study.path().join("pipe.json");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert!(Baseline::read(&pipe).unwrap_err().to_string().contains("is no regular file"));
}

#[test]
fn a_damaged_baseline_is_an_error_that_names_the_file() {
    let study = tempfile::tempdir().unwrap();
    let there = study.path().join("x.json");
    let whole = serde_json::to_string(&baseline()).unwrap();
    for (damaged, reason) in [
        (whole[..40].to_owned(), "EOF while parsing"),
        ("\u{0}".to_owned(), "expected value"),
        ("[]".to_owned(), "invalid length 0"),
        (whole.replace("bmv-baseline/1", "bmv-baseline/9"), "its format is `bmv-baseline/9`"),
        (whole.replace("\"sha256\":\"", "\"sha256\":\"x"), "is not a key"),
        (whole.replace("\"standard_error\":", "\"standard_error\":-"), "`Gh, mean` has no possible error"),
        (whole.replace("\"seed\":2015", "\"seed\":-1"), "invalid value"),
    ] {
        fs::write(&there, damaged).unwrap();
        let error = Baseline::read(&there).unwrap_err().to_string();
        let start = format!("the baseline `{}` cannot be used: ", there.display());
        assert!(error.starts_with(&start) && error.contains(reason), "{error}");
    }
}
