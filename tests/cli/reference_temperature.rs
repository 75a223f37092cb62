//! A strap far below room temperature whose conductance changes with temperature, as typed.

use std::fs;

use serde_json::Value;

use super::studies::printed;

const MODEL: &str = r#"{
  "format": "bmv-network/1", "title": "A cold head on a strap",
  "inputs": {"T_stage": {"unit": "K", "nominal": 100, "range": [60, 200]}, "Q": {"unit": "W", "nominal": 1, "range": [0, 5]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.08, "prior": {"normal": {"mean": 0.08, "sd": 0.004}},
    "description": "strap at its working temperature", "source": "assumed"}},
  "nodes": {"stage": {"boundary": "T_stage"}, "head": {}},
  "conductors": {"strap": {"between": ["head", "stage"], "conductance": "G"}},
  "loads": {"dissipation": {"into": "head", "power": "Q"}}
}"#;

/// Temperature at which the strap conducts 0.08 W/K, K.
const WORKING_K: f64 = 133.15;
/// Relative change of the conductance for a kelvin of mean temperature.
const CHANGE: f64 = -0.004;

/// Readings of phases whose strap conducts 0.08 W/K (1 + CHANGE (Tm - WORKING_K)): the balance is quadratic in the head's temperature.
fn readings() -> String {
    let mut table = String::from("phase,T_stage [K],Q [W],head [K]\n");
    for phase in 0..16_usize {
        let stage = [80.0, 110.0, 130.0, 150.0][phase % 4];
        let heat = [0.5, 1.5, 2.5, 3.5][phase / 4];
        // heat = 0.08 (1 + c (stage + rise / 2 - WORKING)) rise
        let at_stage = 1.0 + CHANGE * (stage - WORKING_K);
        let rise = (-at_stage + (at_stage * at_stage + 2.0 * CHANGE * heat / 0.08).sqrt()) / CHANGE;
        let error = 0.05 * [1.0, -0.6, 0.2, -1.1, 0.7][phase % 5];
        table.push_str(&format!("P{phase:02},{stage},{heat},{:e}\n", stage + rise + error));
    }
    table
}

#[test]
fn a_law_of_temperature_refers_to_where_cold_hardware_works_and_the_next_pass_says_so() {
    let root = tempfile::tempdir().unwrap();
    let study = root.path().join("strap");
    fs::create_dir(&study).unwrap();
    let put = |name: &str, text: &str| fs::write(study.join(name), text).unwrap();
    put("model.json", MODEL);
    put("data.csv", &readings());
    put(
        "pass-1.json",
        r#"{"format": "bmv-pass/1", "title": "Strap, pass 1", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"cold": {"steady": {"file": "data.csv",
            "sensors": {"head": {"measures": "head", "sigma": {"value": 0.05, "unit": "K"}}},
            "held_out": {"phases": ["P05", "P10", "P15"]}}}},
        "jobs": {"missing": {"diagnose": {"data": ["cold"], "effects": ["temperature-dependent-conductance", "prior-of"], "most": 2}}}}"#,
    );
    let found: Value = serde_json::from_str(&printed(&study, &["diagnose", "pass-1.json", "--json"])).unwrap();
    assert_eq!(found["selected"], serde_json::json!(["temperature-dependent-conductance:strap"]), "{found:.3000}");
    let effect = &found["effects"][0];
    // About 20 degC the strap would conduct 0.36 of what the prior allows, and that would be too narrow as well.
    let reference_k = effect["reference_k"].as_f64().unwrap();
    assert!((120.0..150.0).contains(&reference_k), "{reference_k}");
    let value = effect["amplitudes"]["coefficient"]["value"].as_f64().unwrap();
    // Relative to what the strap conducts at the reference.
    let expected = CHANGE / (1.0 + CHANGE * (reference_k - WORKING_K));
    assert!((value - expected).abs() < 0.05 * expected.abs(), "{value} instead of {expected}");

    let said = printed(&study, &["diagnose", "pass-1.json"]);
    let celsius = (reference_k - 273.15).round();
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains(&format!("(reference temperature {celsius} degC)")), "{said}");

    printed(&study, &["adopt", "pass-1.json"]);
    let next: Value = serde_json::from_str(&fs::read_to_string(study.join("pass-2.json")).unwrap()).unwrap();
    let adopted = next["adopt"].as_object().unwrap().values().next().unwrap();
    let usage = &adopted["effect"]["temperature-dependent-conductance"];
    assert_eq!(usage["reference"], serde_json::json!({"value": celsius as i64, "unit": "degC"}), "{usage}");
    printed(&study, &["run", "pass-2.json"]);
    let compared: Value = serde_json::from_str(&printed(&study, &["compare", "pass-2.json", "--json"])).unwrap();
    let left: Vec<f64> = (compared["rows"].as_array().unwrap().iter())
        .map(|row| row["measured"].as_f64().unwrap() - row["predicted_tuned"].as_f64().unwrap())
        .collect();
    // Twice the largest of the errors that the readings have.
    assert!(left.len() == 16 && left.iter().all(|error| error.abs() < 0.11), "{left:?}");
}
