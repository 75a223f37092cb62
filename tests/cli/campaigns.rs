//! Campaigns of other hands, in a folder that the environment names: they load and compare as they are.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The folder of campaigns, or a word that there is none.
fn campaigns() -> Option<PathBuf> {
    let found = std::env::var_os("BMV_CAMPAIGNS").map(PathBuf::from);
    if found.is_none() {
        eprintln!("skipped: BMV_CAMPAIGNS names no folder of campaigns");
    }
    found
}

/// Copies a study's files.
fn copy(from: &Path, to: &Path) {
    for entry in walkdir::WalkDir::new(from) {
        let entry = entry.unwrap();
        let target = to.join(entry.path().strip_prefix(from).unwrap());
        if entry.file_type().is_dir() {
            fs::create_dir_all(target).unwrap();
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

fn compare(pass: &Path) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_bmv"))
        .arg("compare")
        .arg(pass)
        .args(["--json", "--threads", "2", "--cache"])
        .arg(pass.with_file_name("cache"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{}: {said}", pass.display());
    serde_json::from_slice(&output.stdout).unwrap()
}

/// All `rows` of a document, however deep.
fn rows<'v>(value: &'v Value, found: &mut Vec<&'v Value>) {
    match value {
        Value::Object(fields) => {
            for (name, inner) in fields {
                match inner.as_array().filter(|_| name == "rows") {
                    Some(list) => found.extend(list),
                    None => rows(inner, found),
                }
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| rows(inner, found)),
        _ => {}
    }
}

/// Every row with a reading has a finite prediction. Gives the number of rows.
fn check(document: &Value, pass: &Path) -> usize {
    let mut found = Vec::new();
    rows(document, &mut found);
    for row in &found {
        assert!(row["measured"].is_f64() || row["measured"].is_i64(), "{}: {row}", pass.display());
        assert!(row["predicted"].as_f64().is_some_and(f64::is_finite), "{}: {row}", pass.display());
    }
    found.len()
}

#[test]
fn campaigns_load_and_compare_as_they_are() {
    let Some(folder) = campaigns() else { return };
    let passes: Vec<PathBuf> = walkdir::WalkDir::new(&folder)
        .sort_by_file_name()
        .into_iter()
        .map(|entry| entry.unwrap().into_path())
        .filter(|path| path.file_name().is_some_and(|name| name == "pass-1.json"))
        .collect();
    assert!(!passes.is_empty(), "no pass below {}", folder.display());
    for pass in passes {
        let copied = tempfile::tempdir().unwrap();
        copy(pass.parent().unwrap(), copied.path());
        let document = compare(&copied.path().join("pass-1.json"));
        assert!(check(&document, &pass) > 50, "{}", pass.display());
    }
}

#[test]
fn a_right_model_at_its_true_parameters_leaves_the_noise() {
    let Some(folder) = campaigns() else { return };
    let study = folder.join("examples/nothing-missing");
    let read = |path: PathBuf| -> Value { serde_json::from_slice(&fs::read(path).unwrap()).unwrap() };
    let Ok(truth) = fs::read(study.join("truth.json")) else {
        eprintln!("skipped: no example without a missing effect");
        return;
    };
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let copied = tempfile::tempdir().unwrap();
    copy(&study, copied.path());
    let mut model = read(copied.path().join("model.json"));
    for (name, value) in truth["true_parameters_SI"].as_object().unwrap() {
        // A bare number would be in the parameter's unit; all of this campaign's are SI.
        model["parameters"][name]["nominal"] = value.clone();
    }
    fs::write(copied.path().join("model.json"), model.to_string()).unwrap();
    let pass = copied.path().join("pass-1.json");
    let document = compare(&pass);
    check(&document, &pass);
    let sensors = &read(pass)["measurements"]["balance test"]["steady"]["sensors"];
    let mut found = Vec::new();
    rows(&document, &mut found);
    let mut chi2 = 0.0;
    for row in &found {
        let sigma = sensors[row["sensor"].as_str().unwrap()]["sigma"]["value"].as_f64().unwrap();
        let deviation = (row["measured"].as_f64().unwrap() - row["predicted"].as_f64().unwrap()) / sigma;
        chi2 += deviation * deviation;
    }
    // 132 readings: standard deviation of the reduced chi square 0.12.
    let reduced = chi2 / found.len() as f64;
    assert!((0.7..1.4).contains(&reduced), "{reduced} over {} readings", found.len());
}
