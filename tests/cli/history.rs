//! `bmv history` and `bmv adopt`: the error pass by pass, and what cannot be adopted.

use std::fs;

use serde_json::{Value, json};

use super::studies::{bmv, code, plate, printed, text};

#[test]
fn history_says_which_job_a_pass_lacks() {
    let root = plate();
    let said = printed(root.path(), &["history", "plate"]);
    let plain = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        plain.contains(
            "`pass-1.json` has no job of kind calibrate, so that its tuned error and its evidence are not known; add to its \
             jobs `\"tuned\": {\"calibrate\": {}}`."
        ),
        "{said}"
    );
    let found: Value = serde_json::from_str(&printed(root.path(), &["history", "plate", "--json"])).unwrap();
    assert_eq!(found["passes"][0]["missing"], json!(["calibrate"]));
}

/// The study `plate` with its model tuned in pass 1, 2 W more tuned in pass 2, and a pass 3 beside it that is not tuned.
fn passes() -> tempfile::TempDir {
    let root = plate();
    let first = root.path().join("plate/pass-1.json");
    let tuned = fs::read_to_string(&first).unwrap().replace(
        r#""delivered": {"compare": {"data": ["balance"]}}"#,
        r#""tuned": {"calibrate": {}}, "delivered": {"compare": {"data": ["balance"]}}"#,
    );
    fs::write(&first, tuned).unwrap();
    let second = r#"{"format": "bmv-pass/1", "title": "Plate, pass 2", "parent": "pass-1.json",
  "adopt": {"more": {"effect": {"heat-load": {"where": "plate", "parameters": {"power": {"unit": "W", "prior": {"uniform": [0, 4]}}}}},
    "because": "3 K too cold whatever the power"}},
  "jobs": {"tuned": {"calibrate": {"parameters": ["more.power"]}}, "fit": {"compare": {}}}}"#;
    fs::write(root.path().join("plate/pass-2.json"), second).unwrap();
    let third =
        second.replace("pass 2", "pass 3").replace(r#""tuned": {"calibrate": {"parameters": ["more.power"]}}, "#, "");
    fs::write(root.path().join("plate/pass-3.json"), third).unwrap();
    root
}

fn near(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

#[test]
fn history_tells_the_error_of_each_pass_and_how_it_fell() {
    let root = passes();
    let found: Value = serde_json::from_str(&printed(root.path(), &["history", "plate", "--json"])).unwrap();
    let passes = found["passes"].as_array().unwrap();
    let names: Vec<&Value> = passes.iter().map(|pass| &pass["pass"]).collect();
    assert_eq!(names, ["pass-1.json", "pass-2.json", "pass-3.json"]);
    let [one, two, three] = passes.as_slice() else { panic!("three") };
    assert_eq!((&one["adopted"], &one["parent"]), (&json!([]), &Value::Null));
    near(&one["rmse_k"]["delivered"]["train"], 3.0, 1e-9);
    near(&one["rmse_k"]["delivered"]["held_out"], 3.0, 1e-9);
    // The reading of 43 degC at 10 W is met by 10 / 23 W/K, which lies within the prior; 5 W then give 11.5 K of 13 K.
    near(&one["rmse_k"]["tuned"]["train"], 0.0, 1e-3);
    near(&one["rmse_k"]["tuned"]["held_out"], 1.5, 1e-3);
    assert_eq!((&two["adopted"], &two["added"]), (&json!(["heat-load:plate"]), &json!(["heat-load:plate"])));
    // 3 K at 0.5 W/K are 1.5 W, in both phases; its prior is flat.
    near(&two["rmse_k"]["tuned"]["train"], 0.0, 1e-3);
    near(&two["rmse_k"]["tuned"]["held_out"], 0.0, 1e-3);
    // Its nominal value, 2 W, is 4 K.
    near(&two["rmse_k"]["delivered"]["train"], 1.0, 1e-9);
    near(&two["mean_k"]["delivered"]["held_out"], -1.0, 1e-9);
    near(&two["within_limit"]["tuned"]["held_out"], 1.0, 0.0);
    assert!(two["log_evidence"].is_f64() && two["converged"] == true, "{two}");
    assert_eq!(two["reduced_chi2"], Value::Null, "one reading, one unknown");
    assert_eq!(three["rmse_k"]["tuned"], json!({"train": null, "held_out": null}), "it is not tuned");
    assert_eq!(three["log_evidence"], Value::Null);
    insta::assert_snapshot!(printed(root.path(), &["history", "plate"]), @r#"
    Error by pass
    =============

    Root mean square of measured minus predicted over all sensors in kelvin. As delivered: nominal
    parameters; tuned: the most probable parameters of the pass's calibration, which saw the readings
    for fitting alone.

    - `pass-1.json` as delivered → tuned, without new physics: RMSE held-out 3.00 K → 1.50 K, for
      fitting 3.00 K → 0.00 K.
    - `pass-2.json` adds `heat-load:plate`: RMSE held-out 1.50 K → 0.00 K, for fitting 0.00 K → 0.00 K
      (tuned, against `pass-1.json`).
    - `pass-3.json` adds `heat-load:plate`: RMSE held-out 3.00 K → 1.00 K, for fitting 3.00 K → 1.00 K
      (untuned, against `pass-1.json`).

    Readings for fitting / held out. Untuned: at nominal parameters, as delivered; what a pass adopts
    stands at its nominal size there, so that tuned errors alone tell whether it helped. Mean deviation
    (measured minus predicted) and share within the limit are of the tuned state where there is one.
    Reduced chi-square: sum of squares of the whitened residuals over readings less unknowns, by the
    noise of the calibration; a diagnosis that estimates the noise itself tells another. Evidence
    compares passes that fit the same readings.
    Pass                RMSE   RMSE tuned       Mean [K]     Within 3 K       Log
                 untuned [K]          [K]                                evidence
    -----------  -----------  -----------  -------------  -------------  --------
    pass-1.json  3.00 / 3.00  0.00 / 1.50   0.00 / +1.50  100 % / 100 %     -2.35
    pass-2.json  1.00 / 1.00  0.00 / 0.00    0.00 / 0.00  100 % / 100 %     -2.08
    pass-3.json  1.00 / 1.00            —  -1.00 / -1.00  100 % / 100 %         —

    - `pass-3.json` has no job of kind calibrate, so that its tuned error and its evidence are not
      known; add to its jobs `"tuned": {"calibrate": {}}`.
    "#);
}

#[test]
#[ignore = "thorough"]
fn a_report_shows_the_passes_up_to_its_own() {
    let root = passes();
    let first = printed(root.path(), &["report", "plate/pass-1.json"]);
    let alone = fs::read_to_string(root.path().join(first.trim())).unwrap();
    assert!(!alone.contains("id=\"history\""), "one pass is no history");
    printed(root.path(), &["report", "plate/pass-2.json"]);
    let folder = root.path().join("reports/plate/pass-2");
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    let page = text(&read("report.html"));
    assert!(page.contains("id=\"history\"") && !page.contains("pass-3.json"), "{page:.300}");
    let manifest: Value = serde_json::from_slice(&read("manifest.json")).unwrap();
    let jobs = manifest["jobs"].as_object().unwrap();
    for job in ["plate/pass-1.json:tuned", "plate/pass-1.json:delivered", "plate/pass-2.json:fit"] {
        assert!(jobs.contains_key(job), "{job} in {jobs:?}");
    }
    // The same bytes, whether the study or the pass was named.
    let before = read("report.html");
    printed(root.path(), &["report", "plate"]);
    assert_eq!(before, read("report.html"));
}

#[test]
fn what_has_no_history_or_no_diagnosis_says_so() {
    let root = plate();
    fs::create_dir(root.path().join("other")).unwrap();
    for file in ["model.json", "pass-1.json"] {
        fs::copy(root.path().join("plate").join(file), root.path().join("other").join(file)).unwrap();
    }
    fs::create_dir(root.path().join("other/data")).unwrap();
    fs::copy(root.path().join("plate/data/balance.csv"), root.path().join("other/data/balance.csv")).unwrap();
    let wrong = |arguments: &[&str], part: &str| {
        let output = bmv(root.path(), arguments);
        let said = text(&output.stderr);
        assert_eq!(code(&output), 2, "{arguments:?}: {said}");
        assert!(said.contains(part) && output.stdout.is_empty(), "{arguments:?}: {said}");
    };
    wrong(&["history", "."], "`.` holds several studies; name one: other, plate");
    wrong(&["history", "none"], "does not exist");
    wrong(&["adopt", "plate/pass-1.json"], "has no job of kind `diagnose`; give it one, as in \"jobs\": {\"missing\"");
    let pass = root.path().join("plate/pass-1.json");
    let two = fs::read_to_string(&pass)
        .unwrap()
        .replace(r#""prior": {"propagate""#, r#""a": {"diagnose": {}}, "b": {"diagnose": {}}, "prior": {"propagate""#);
    fs::write(&pass, two).unwrap();
    wrong(&["adopt", "plate/pass-1.json", "--job", "c"], "has no `diagnose` job `c`; it has `a` and `b`");
    assert!(!root.path().join("plate/pass-2.json").exists());
}
