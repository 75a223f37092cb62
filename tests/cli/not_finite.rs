//! Quantities without a number: what fails says which quantity, where and at which parameters, and nothing else fails with it.

use std::fs;

use tempfile::TempDir;

use super::studies::{bmv, code, text};

/// A plate on a wall. `gap` is infinite where `x` is 1, its nominal value; `room` where it is 1.2 or more.
const MODEL: &str = r#"{
  "format": "bmv-network/1", "title": "Plate", "description": "A plate on a wall.",
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}, "description": "mount", "source": "made up"},
    "x": {"unit": "1", "nominal": 1, "prior": PRIOR, "description": "a ratio", "source": "made up"},
    "A": {"unit": "1", "nominal": 2, "prior": {"fixed": 2}, "description": "a size", "source": "made up"}},
  "inputs": {"Q": {"unit": "W", "nominal": 10, "range": [0, 20]}, "T_wall": {"unit": "degC", "nominal": 20}},
  "nodes": {"plate": {"capacity": 100}, "wall": {"boundary": "T_wall"}},
  "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}},
  "quantities": {"plate temperature": {"temperature": "plate"},
    "gap": {"expression": {"of": "A / (x - 1)", "unit": "1"}},
    "room": {"expression": {"of": "A / max(1.2 - x, 0)", "unit": "1"}}}
}"#;

const PASS: &str = r#"{
  "format": "bmv-pass/1", "title": "Plate, pass 1", "description": "", "parent": null, "model": "model.json", "seed": 1,
  "requirements": {"open": {"quantity": "gap", "above": {"value": 1, "unit": "1"}, "probability": 0.9}},
  "measurements": {"balance": {"steady": {
    "file": "data/balance.csv",
    "columns": {"Q": {"header": "Q", "unit": "W"}, "g": {"header": "g", "unit": "1"}, "plate": {"header": "plate", "unit": "degC"}},
    "sensors": {"g": {"measures": "gap", "sigma": 0.5}, "plate": {"measures": "plate", "sigma": {"value": 0.5, "unit": "K"}}}
  }}},
  "jobs": {JOBS}
}"#;

fn study(prior: &str, jobs: &str) -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let study = root.path().join("plate");
    fs::create_dir_all(study.join("data")).unwrap();
    fs::write(study.join("model.json"), MODEL.replace("PRIOR", prior)).unwrap();
    fs::write(study.join("pass-1.json"), PASS.replace("JOBS", jobs)).unwrap();
    fs::write(study.join("data/balance.csv"), "phase,Q,g,plate\nP1,10,3,40\nP2,5,3,30\n").unwrap();
    root
}

/// Runs a job beside one that is sound: what is said of the first; the second has its result.
fn said(prior: &str, job: &str) -> String {
    let sound = r#""sound": {"propagate": {"samples": 64, "quantities": ["plate temperature"], "requirements": []}}"#;
    let root = study(prior, &format!(r#"{sound}, "bad": {job}"#));
    let output = bmv(root.path(), &["run", "plate"]);
    // 2 where the job is refused before it runs, else 3.
    assert!(matches!(code(&output), 2 | 3), "{}{}", text(&output.stdout), text(&output.stderr));
    let shown = text(&bmv(root.path(), &["show", "plate/pass-1.json", "sound", "--json"]).stdout);
    assert!(shown.contains("\"plate temperature\""), "{shown}");
    bmv(root.path(), &["report", "plate"]);
    assert!(root.path().join("reports/plate/pass-1/report.html").exists(), "rendered, with what there is");
    text(&output.stdout) + &text(&output.stderr)
}

#[track_caller]
fn names(said: &str, words: &[&str]) {
    // Lines are wrapped.
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(said.contains(word), "`{word}` in: {said}");
    }
    assert!(!said.contains("not readable") && !said.contains("null"), "{said}");
}

const FREE: &str = r#"{"uniform": [0.5, 1.5]}"#;
const FIXED: &str = r#"{"fixed": 1}"#;

#[test]
fn a_propagation_of_what_is_infinite_at_nominal_parameters_is_refused() {
    let said = said(FREE, r#"{"propagate": {"samples": 64, "quantities": ["gap"]}}"#);
    names(&said, &["bad", "quantity `gap` is inf", "nominal parameters", "x = 1"]);
}

#[test]
fn samples_without_a_number_count_as_failed() {
    let job = r#"{"propagate": {"samples": 64, "quantities": ["room"], "requirements": []}}"#;
    names(&said(FREE, job), &["of 64 samples failed", "the limit of", "sample ", "quantity `room` is inf (", "x = 1."]);
}

#[test]
#[ignore = "thorough"]
fn sensitivity_goal_and_margins_name_the_quantity_and_the_parameters() {
    names(
        &said(FREE, r#"{"sensitivity": {"samples": 64, "quantities": ["gap"]}}"#),
        &["quantity `gap` is inf", "x = 1"],
    );
    // An infinite gap is above every limit, and yet no sample meets it.
    let goal = r#"{"goal": {"samples": 1024}}"#;
    names(&said(FIXED, goal), &["1024 of 1024 solves failed", "limit of", "sample 0", "quantity `gap` is inf", "G = "]);
    let margins = r#"{"conventional": {"design_variable": {"A": {"from": 1, "to": 3}}, "rules": ["none"]}}"#;
    names(&said(FREE, margins), &["requirement `open`", "quantity `gap` is inf", "x = 1"]);
}

#[test]
fn a_comparison_tells_which_sensor_has_no_prediction() {
    let root = study(FREE, r#""delivered": {"compare": {"data": ["balance"]}}"#);
    let output = bmv(root.path(), &["show", "plate/pass-1.json", "delivered", "--run", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    assert!(shown.contains("sensor `g`: quantity `gap` is inf") && shown.contains("\"plate\""), "{shown}");
}

#[test]
fn a_calibration_passes_over_points_without_a_likelihood_and_counts_them() {
    let root =
        study(FREE, r#""fit": {"calibrate": {"data": ["balance"], "sampler": "smc", "chains": 4, "draws": 100}}"#);
    // What it reads is infinite in three of ten draws from the prior.
    let file = root.path().join("plate/pass-1.json");
    let pass = fs::read_to_string(&file).unwrap().replace(r#""measures": "gap""#, r#""measures": "room""#);
    fs::write(&file, pass).unwrap();
    let shown = text(&bmv(root.path(), &["show", "plate/pass-1.json", "fit", "--run", "--json"]).stdout);
    assert!(shown.contains("evaluations failed"), "{shown}");
}

#[test]
fn a_design_does_not_allow_a_candidate_whose_readings_have_no_number() {
    let job = r#""test": {"design": {"learn": ["G"], "nuisance": [], "conditions": {"Q": [5, 10]}, "outer": 256, "inner": 64,
        "sensors": {"g": {"measures": "gap", "sigma": 0.5}}}}"#;
    let root = study(FIXED, job);
    let output = bmv(root.path(), &["run", "plate"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = text(&bmv(root.path(), &["show", "plate/pass-1.json", "test", "--json"]).stdout);
    let document: serde_json::Value = serde_json::from_str(&shown).expect("a document");
    assert!(document["best"].is_null(), "{shown}");
    let because = document["candidates"][0]["because"].as_str();
    assert_eq!(because, Some("no solution in 100.0 % of the samples"), "{shown}");
}
