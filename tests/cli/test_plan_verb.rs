//! `bmv test-plan`: a plate of one node, of which everything is known in closed form; the sheet, filled in, is what `compare` reads.

use std::fs;
use std::path::Path;

use bmv::math::functions::ln;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::studies::{bmv, code, printed, text};

/// Heat capacity, J/K; the wall, K; power, W.
const CAPACITY: f64 = 500.0;
const WALL_K: f64 = 293.15;
const POWER_W: f64 = 10.0;

/// A plate on a wall: 10 W give 10 / G above the wall, G between 0.4 and 0.6 W/K, nominally 0.5.
fn study() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("plate");
    fs::create_dir_all(folder.join("data")).unwrap();
    let model = json!({"format": "bmv-network/1", "title": "Plate",
        "inputs": {"Q": {"unit": "W", "nominal": 0}, "T_w": {"unit": "degC", "nominal": 20}},
        "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}}},
        "nodes": {"wall": {"boundary": "T_w"},
            "plate": {"capacity": CAPACITY, "limits": {"yellow": [273.15, 313.15], "red": [253.15, 315.15]}}},
        "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G"}},
        "loads": {"heater": {"into": "plate", "power": "Q"}},
        "quantities": {"plate temperature": {"temperature": "plate"}}});
    fs::write(folder.join("model.json"), model.to_string()).unwrap();
    let pass = json!({"format": "bmv-pass/1", "title": "Plate", "parent": null, "model": "model.json", "seed": 5,
        "jobs": {
            "choose": {"design": {"conditions": {"Q": [POWER_W]}, "pick": 2, "outer": 256, "inner": 64,
                "limits": {"red": 0.5},
                "sensors": {"T1, left": {"measures": "plate", "sigma": {"value": 0.3, "unit": "K"}}}}},
            "plan": {"test-plan": {"objectives": ["Learn to test."], "success": ["Nobody is hurt."],
                "hold": {"value": 30, "unit": "min"}}}}});
    fs::write(folder.join("pass-1.json"), pass.to_string()).unwrap();
    root
}

#[test]
fn predictions_limits_and_durations_are_those_of_the_closed_form() {
    let root = study();
    let plan: Value =
        serde_json::from_str(&printed(root.path(), &["test-plan", "plate/pass-1.json", "--json"])).unwrap();
    let phases = plan["phases"].as_array().unwrap();
    assert_eq!(phases.len(), 2);
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is a number"));
    let sensor = &phases[0]["sensors"][0];
    assert!((number(&sensor["nominal"]) - (WALL_K + POWER_W / 0.5)).abs() < 1e-9);
    // 1024 Sobol points: quantiles of a uniform G to a thousandth of its range, 0.1 K at most here.
    let at = |share: f64| WALL_K + POWER_W / (0.6 - 0.2 * share);
    for (end, share) in [0.025, 0.975].into_iter().enumerate() {
        let found = number(&sensor["band"][end]);
        assert!((found - at(share)).abs() < 0.05, "{found} {}", at(share));
    }
    // Mean of 10 / G over a uniform G.
    let mean = WALL_K + POWER_W * ln(0.6 / 0.4) / 0.2;
    assert!((number(&sensor["mean"]) - mean).abs() < 0.01, "{} {mean}", sensor["mean"]);
    // Red above 22 K: G below 10 / 22; yellow above 20 K: G below 0.5. A point of 1024 is a thousandth.
    let limits = &phases[0]["limits"][0];
    let red = (POWER_W / 22.0 - 0.4) / 0.2;
    assert!((number(&limits["outside_red"]["value"]) - red).abs() < 0.003, "{limits} {red}");
    assert!((number(&limits["outside_yellow"]["value"]) - 0.5).abs() < 0.003, "{limits}");
    // From 0 W: the plate moves by dT exp(-t / tau) / tau, until that is 1 K in 5 h. Instants are 2.25 % apart.
    let (step, tau, rate) = (POWER_W / 0.5, CAPACITY / 0.5, 1.0 / 18_000.0);
    let steady = tau * ln(step / (tau * rate));
    let settling = &phases[0]["settling"];
    let found = number(&settling["nominal_s"]);
    assert!((found / steady - 1.0).abs() < 0.0235, "{found} {steady}");
    // The decay is exponential; the integration is accurate to some mK of 0.2 K at the later point.
    assert!((number(&settling["time_constant_s"]) / tau - 1.0).abs() < 0.01, "{settling}");
    let quantiles: Vec<f64> = settling["quantiles_s"].as_array().unwrap().iter().map(number).collect();
    assert!(quantiles[0] < quantiles[1] && quantiles[1] < quantiles[2], "{quantiles:?}");
    // A stiffer mount is sooner steady: the ends lie within those of G = 0.6 and 0.4, the grid of instants apart.
    let of = |conductance: f64| {
        let tau = CAPACITY / conductance;
        tau * ln(POWER_W / conductance / (tau * rate))
    };
    assert!(quantiles[0] > 0.98 * of(0.6) && quantiles[2] < 1.03 * of(0.4), "{quantiles:?}");
    // The second phase repeats the first: steady at once, which is said.
    assert_eq!(phases[1]["settling"]["nominal_s"], 0.0);
    assert!((number(&plan["duration_s"][0]) - (found + 2.0 * 1800.0)).abs() < 1e-6);
    let findings = plan["findings"].to_string();
    assert!(findings.contains("P02 repeats the set points of P01"), "{findings}");
    let shown = printed(root.path(), &["test-plan", "plate/pass-1.json"]);
    for part in ["Learn to test.", "Nobody is hurt.", "Limits", "Steady after", "Data sheet"] {
        assert!(shown.contains(part), "{part}\n{shown}");
    }
}

/// The measurement that is printed, put into a pass that has the sheet with these readings.
fn filled(root: &Path, readings: [f64; 2]) {
    let output = bmv(root, &["test-plan", "plate/pass-1.json", "--sheet", "plate/data/sheet.csv"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = text(&output.stderr);
    let line = said.lines().find(|line| line.starts_with("\"measurements\"")).expect("the measurement is printed");
    let measurements: Value = serde_json::from_str(&format!("{{{line}}}")).expect("JSON");
    let sheet = root.join("plate/data/sheet.csv");
    let empty = fs::read_to_string(&sheet).unwrap();
    assert_eq!(empty, "phase,Q [W],T_w [degC],\"T1, left [degC]\"\nP01,10,20,\nP02,10,20,\n");
    let mut lines: Vec<String> = empty.lines().map(str::to_owned).collect();
    lines[1].push_str(&readings[0].to_string());
    lines[2].push_str(&readings[1].to_string());
    fs::write(&sheet, lines.join("\n") + "\n").unwrap();
    let pass = json!({"format": "bmv-pass/1", "title": "Tested", "parent": "pass-1.json", "model": "model.json", "seed": 5,
        "measurements": measurements["measurements"], "jobs": {"delivered": {"compare": {}}}});
    fs::write(root.join("plate/pass-2.json"), pass.to_string()).unwrap();
}

#[test]
fn the_sheet_filled_in_is_what_compare_reads() {
    let root = study();
    filled(root.path(), [41.5, 39.5]);
    let compared: Value =
        serde_json::from_str(&printed(root.path(), &["compare", "plate/pass-2.json", "--json"])).unwrap();
    let train = &compared["train"];
    // Predicted 40 degC in both phases: +1.5 and -0.5 K.
    assert_eq!(train["count"], 2);
    assert!((train["mean"].as_f64().unwrap() - 0.5).abs() < 1e-6, "{train}");
    assert!((train["max"].as_f64().unwrap() - 1.5).abs() < 1e-6, "{train}");
    // A sheet with readings in it is not written over.
    let again = bmv(root.path(), &["test-plan", "plate/pass-1.json", "--sheet", "plate/data/sheet.csv"]);
    assert_eq!(code(&again), 2, "{}", text(&again.stderr));
    assert!(fs::read_to_string(root.path().join("plate/data/sheet.csv")).unwrap().contains("41.5"));
    let none = bmv(root.path(), &["test-plan", "plate/pass-2.json"]);
    assert_eq!(code(&none), 2, "{}", text(&none.stderr));
    assert!(text(&none.stderr).contains("no job of kind `test-plan`"), "{}", text(&none.stderr));
}
