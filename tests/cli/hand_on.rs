//! Calibration handed on from pass to pass, as a user sees it.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::studies::{bmv, code, plate, printed, text};

/// Replaces the jobs of the plate's pass.
fn jobs(folder: &Path, jobs: &str) {
    let path = folder.join("plate/pass-1.json");
    let pass = fs::read_to_string(&path).unwrap();
    let start = pass.find("\"jobs\"").unwrap();
    fs::write(&path, format!("{}\"jobs\": {jobs}}}", &pass[..start])).unwrap();
}

/// A second pass of the plate: other rows, the posterior of the first as prior.
const SECOND: &str = r#"{
  "format": "bmv-pass/1", "title": "Plate, pass 2", "parent": "pass-1.json",
  "parameters": {"G": {"prior": {"posterior": {"pass": "pass-1.json", "job": "fit"}}, "because": "handed on"}},
  "measurements": {"balance": {"steady": {
    "file": "data/balance.csv",
    "columns": {"Q": {"header": "Q", "unit": "W"}, "T_wall": {"header": "wall", "unit": "degC"}, "plate": {"header": "plate", "unit": "degC"}},
    "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.5, "unit": "K"}}},
    "held_out": {"phases": ["P1"]}
  }}},
  "jobs": {
    "more": {"calibrate": {}},
    "spread": {"propagate": {"samples": 256}},
    "flight": {"predict": {"from": {"pass": "pass-1.json", "job": "fit"}, "samples": 256, "sweep": {"Q": [12, 10, 8]}}}
  }
}"#;

#[test]
#[ignore = "thorough"]
fn the_second_pass_builds_on_the_first_with_the_same_bytes_for_any_threads() {
    let root = plate();
    // Wide enough that the data decide.
    let model = root.path().join("plate/model.json");
    fs::write(&model, fs::read_to_string(&model).unwrap().replace("[0.4, 0.6]", "[0.2, 0.8]")).unwrap();
    jobs(root.path(), r#"{"fit": {"calibrate": {}}}"#);
    fs::write(root.path().join("plate/pass-2.json"), SECOND).unwrap();
    let show = |threads: &str| {
        let cache = format!("cache-{threads}");
        printed(root.path(), &["show", "plate/pass-2.json", "--run", "--json", "--threads", threads, "--cache", &cache])
    };
    let (one, two) = (show("1"), show("2"));
    assert_eq!(one, two);
    let all: Value = serde_json::from_str(&one).unwrap();
    let mean = all["more"]["parameters"]["G"]["mean"].as_f64().unwrap();
    // 10 W and 5 W, 23 K and 13 K above the wall: least squares of both give 125 / 295 W/K, half a standard deviation
    // of 0.0088 W/K about it for the draws of the prior and the mean's place beside the mode.
    assert!((mean - 125.0 / 295.0).abs() < 0.0044, "{mean}");
    assert_eq!(all["more"]["posterior_priors"][0]["source"], "`fit` of `pass-1.json`");
    assert_eq!(all["spread"]["posterior_priors"][0]["parameters"][0], "G");
    assert_eq!(all["flight"]["converged"], true);
    assert!(all["flight"]["prior"]["probability"]["plate"]["value"].is_number());
    // The plan has what is needed of the first pass, and nothing else.
    let plan = printed(root.path(), &["plan", "plate/pass-2.json", "--cache", "empty"]);
    assert!(plan.contains("plate/pass-1.json:fit") && plan.contains("5 of 5 jobs to run"), "{plan}");
    // A change of the first pass's data changes the keys of the second.
    fs::write(root.path().join("plate/data/balance.csv"), "phase,Q,wall,plate\nP1,10,20,43.1\nP2,5,20,33\n").unwrap();
    let plan = printed(root.path(), &["plan", "plate/pass-2.json", "--cache", "cache-1"]);
    assert!(plan.contains("5 of 5 jobs to run"), "{plan}");
    let run = bmv(root.path(), &["show", "plate/pass-2.json", "--run"]);
    assert!(text(&run.stdout).contains("Prediction after calibration"), "{}", text(&run.stdout));
}

#[test]
fn a_comparison_tells_that_its_calibration_did_not_converge() {
    let root = plate();
    jobs(root.path(), r#"{"fit": {"calibrate": {"draws": 8, "warmup": 20}}, "delivered": {"compare": {}}}"#);
    for option in ["--tuned", "--rows=none"] {
        // The second time from the cache.
        let output = bmv(root.path(), &["compare", "plate/pass-1.json", option]);
        assert_eq!(code(&output), 4, "{}", text(&output.stderr));
    }
}

#[test]
fn a_sensor_without_noise_stops_the_calibration_and_not_the_comparison() {
    let root = plate();
    jobs(root.path(), r#"{"fit": {"calibrate": {}}, "delivered": {"compare": {"from": "fit"}}}"#);
    let path = root.path().join("plate/pass-1.json");
    let pass = fs::read_to_string(&path).unwrap().replace(r#", "sigma": {"value": 0.5, "unit": "K"}"#, "");
    fs::write(&path, pass).unwrap();
    let output = bmv(root.path(), &["compare", "plate/pass-1.json"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let output = bmv(root.path(), &["run", "plate"]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("[no-sigma]") && said.contains("plate/pass-1.json:7:"), "{said}");
    assert!(text(&output.stdout).contains("delivered: RMSE"), "the comparison ran");
}

/// Both phases of the plate are held out, so that its calibration cannot be made.
fn nothing_to_fit(jobs_of_first: &str) -> tempfile::TempDir {
    let root = plate();
    jobs(root.path(), jobs_of_first);
    let path = root.path().join("plate/pass-1.json");
    let pass = fs::read_to_string(&path).unwrap().replace(r#"["P2"]"#, r#"["P1", "P2"]"#);
    fs::write(&path, pass).unwrap();
    root
}

#[test]
fn a_job_that_cannot_be_made_keeps_only_what_builds_on_it_from_running() {
    let root = nothing_to_fit(
        r#"{"fit": {"calibrate": {}}, "delivered": {"compare": {"from": "fit"}},
    "flight": {"predict": {"from": "fit"}}, "spread": {"propagate": {"samples": 64}}}"#,
    );
    let output = bmv(root.path(), &["run", "plate"]);
    let (said, printed) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("error[job-refused]: job `fit` cannot be made: there is no reading to fit"), "{said}");
    assert!(said.contains("plate/pass-1.json:10:12") && said.contains("at $.jobs.fit"), "{said}");
    assert!(said.contains("job `flight` cannot be made: it builds on `fit` of `pass-1.json`"), "{said}");
    assert!(printed.contains("delivered: ") && printed.contains("spread: "), "{printed}");
    // Nothing is wrong with what is asked for alone.
    let output = bmv(root.path(), &["run", "plate", "--job", "propagate"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("job-refused"));
    let output = bmv(root.path(), &["show", "plate/pass-1.json", "flight"]);
    assert_eq!(code(&output), 2, "{}", text(&output.stderr));
    let output = bmv(root.path(), &["report", "plate", "--out", "reports"]);
    assert_eq!(code(&output), 2, "{}", text(&output.stderr));
    let report = fs::read_to_string(root.path().join("reports/plate/pass-1/report.md")).unwrap();
    for part in ["Job fit has no result: there is no reading to fit", "Job flight has no result: it builds on"] {
        assert!(report.contains(part), "{part}\n{report}");
    }
}

#[test]
fn what_builds_on_a_job_of_another_pass_that_cannot_be_made_says_why() {
    let root = nothing_to_fit(r#"{"fit": {"calibrate": {}}}"#);
    fs::write(root.path().join("plate/pass-2.json"), SECOND).unwrap();
    let output = bmv(root.path(), &["run", "plate/pass-2.json"]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("job `more` cannot be made: it builds on `fit` of `pass-1.json`"), "{said}");
    assert_eq!(said.matches("job `fit` cannot be made: there is no reading to fit").count(), 1, "{said}");
    assert!(text(&output.stdout).contains("comparison: "), "{}", text(&output.stdout));
}

#[test]
fn a_report_says_which_job_failed_and_why() {
    let root = plate();
    let model = root.path().join("plate/model.json");
    let changed =
        fs::read_to_string(&model).unwrap().replace(r#""power": "Q""#, r#""power": "Q + 1e-9 * log(G - 0.45)""#);
    fs::write(&model, changed).unwrap();
    let output = bmv(root.path(), &["report", "plate", "--out", "reports"]);
    assert_eq!(code(&output), 3, "{}", text(&output.stderr));
    let report = fs::read_to_string(root.path().join("reports/plate/pass-1/report.md")).unwrap();
    assert!(report.contains("Job prior has no result: ") && report.contains("samples failed"), "{report}");
}
