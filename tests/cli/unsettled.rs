//! What a verdict leaves open, or rests on and should not: rivals that no test parts, and a start that the data contradict.

use std::fs;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::studies::{bmv, code, printed, text};

/// A box on a wall, behind which a lid hangs without a sensor.
fn model() -> Value {
    json!({"format": "bmv-network/1", "title": "Box and lid",
        "inputs": {"T_w": {"unit": "degC", "nominal": 20, "range": [0, 40], "settable": true}, "Q": {"unit": "W", "nominal": 4, "range": [0, 10], "settable": true}},
        "parameters": {"G": {"unit": "W/K", "nominal": 1.0, "prior": {"uniform": [0.99, 1.01]}}},
        "nodes": {"wall": {"boundary": "T_w"}, "box": {"capacity": 900}, "lid": {"capacity": 300}},
        "conductors": {"foot": {"between": ["box", "wall"], "conductance": "G"}, "hinge": {"between": ["lid", "box"], "conductance": 0.5}},
        "loads": {"heater": {"into": "box", "power": "Q"}}})
}

fn study(measurement: Value, data: &str) -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("box");
    fs::create_dir_all(folder.join("data")).unwrap();
    fs::write(folder.join("model.json"), model().to_string()).unwrap();
    let pass = json!({"format": "bmv-pass/1", "title": "As delivered", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"test": measurement},
        "jobs": {"missing": {"diagnose": {"effects": ["heat-load"], "most": 1}}, "tuned": {"calibrate": {}}}});
    fs::write(folder.join("pass-1.json"), pass.to_string()).unwrap();
    fs::write(folder.join("data/test.csv"), data).unwrap();
    root
}

fn sensor() -> Value {
    json!({"box": {"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}})
}

#[test]
#[ignore = "thorough"]
fn rivals_that_no_phase_parts_are_said_to_be_so_and_adopted_by_name_only() {
    // 1.5 W that the model does not have: into the box or into the lid is all the same to the box.
    let mut data = "phase,T_w [degC],Q [W],box [degC]\n".to_owned();
    for (row, (wall, heater)) in
        [(0.0, 2.0), (10.0, 8.0), (20.0, 4.0), (30.0, 6.0), (40.0, 0.0), (5.0, 9.0)].iter().enumerate()
    {
        let noise = [0.06, -0.08, 0.03, -0.02, 0.07, -0.05][row];
        data.push_str(&format!("P{row},{wall},{heater},{}\n", wall + heater + 1.5 + noise));
    }
    let root = study(json!({"steady": {"file": "data/test.csv", "sensors": sensor()}}), &data);
    let found: Value = serde_json::from_str(&printed(root.path(), &["diagnose", "box/pass-1.json", "--json"])).unwrap();
    assert_eq!(found["verdict"], "ambiguous", "{found}");
    assert!(found["separating_experiment"].is_null(), "{found}");
    // The missing heat presses the conductance against its bound; both count it as an unknown.
    let history: Value = serde_json::from_str(&printed(root.path(), &["history", "box", "--json"])).unwrap();
    let [own, other] =
        [&found["misfit"]["reduced_chi2"], &history["passes"][0]["reduced_chi2"]].map(|v| v.as_f64().unwrap());
    assert!((own / other - 1.0).abs() < 1e-4, "{own} by diagnose, {other} by history");
    let output = bmv(root.path(), &["diagnose", "box/pass-1.json"]);
    let (said, next) = (text(&output.stdout).replace('\n', " "), text(&output.stderr));
    assert!(
        said.contains("No steady phase within the stated ranges reliably tells heat-load:")
            && said.contains("Perhaps missing: "),
        "{said}"
    );
    assert!(!said.contains("conditions stated below"), "{said}");
    assert!(next.contains("adopted by name, as in bmv adopt box/pass-1.json heat-load:"), "{next}");

    let refused = bmv(root.path(), &["adopt", "box/pass-1.json"]);
    let said = text(&refused.stderr);
    assert_eq!(code(&refused), 2, "{said}");
    assert!(
        said.contains("these data leave open whether it is `heat-load:") && said.contains("; no steady phase"),
        "{said}"
    );
    assert!(!root.path().join("box/pass-2.json").exists());

    let named = bmv(root.path(), &["adopt", "box/pass-1.json", "heat-load:lid"]);
    let warned = text(&named.stderr);
    assert_eq!(code(&named), 0, "{warned}");
    assert!(
        warned.contains("warning[adopt-ambiguous]: these data leave open whether it is `heat-load:lid`"),
        "{warned}"
    );
    assert!(warned.contains("(probability 0.") && warned.contains("its rivals: `heat-load:box` (0."), "{warned}");
    assert!(root.path().join("box/pass-2.json").exists());
}

#[test]
#[ignore = "thorough"]
fn a_wrong_start_is_named_before_the_verdict() {
    let mut data = "time [s],T_w [degC],Q [W],box [degC]\n".to_owned();
    for row in 0..25 {
        let time = 200.0 * f64::from(row);
        data.push_str(&format!("{time},20,4,{:.2}\n", 24.0 + 8.0 * bmv::math::functions::exp(-time / 1100.0)));
    }
    let initial = json!({"temperatures": {"all": {"value": 20, "unit": "degC"}}});
    let root = study(json!({"transient": {"file": "data/test.csv", "initial": initial, "sensors": sensor()}}), &data);
    let said = printed(root.path(), &["diagnose", "box/pass-1.json"]).replace('\n', " ");
    let before =
        said.find("Check this before relying on the result: the first readings of test lie apart").expect(&said);
    assert!(before < said.find("Verdict: ").expect("a verdict"), "{said}");
    assert!(said.contains(r#"Repair: "initial": {"measured": {}}"#) && said.contains("with a prior"), "{said}");
    let output = bmv(root.path(), &["diagnose", "box/pass-1.json"]);
    assert!(
        text(&output.stderr).contains("next: check the start, then bmv diagnose again"),
        "{}",
        text(&output.stderr)
    );

    let said = printed(root.path(), &["run", "box"]);
    let lines: Vec<&str> = said.lines().collect();
    for job in ["  missing: ", "  tuned: "] {
        let at = lines.iter().position(|line| line.starts_with(job)).unwrap_or_else(|| panic!("{job} in {said}"));
        assert!(lines[at..(at + 4).min(lines.len())].iter().any(|line| line.contains("Check this before")), "{said}");
    }
    let adopted = bmv(root.path(), &["adopt", "box/pass-1.json", "heat-load:box", "--force"]);
    assert!(text(&adopted.stderr).contains("warning: Check this before"), "{}", text(&adopted.stderr));
}
