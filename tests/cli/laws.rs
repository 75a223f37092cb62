//! From an unknown function to physics: a heat that no effect of the catalogue has is drawn as a curve, and the law that
//! the curve follows is adopted.

use std::fs;

use bmv::math::functions::exp;
use bmv::random::StreamKey;
use serde_json::Value;
use tempfile::TempDir;

use super::studies::{bmv, code, printed};

/// A box on a plate; a pump gives it `2 (1 - exp(-v / 25))` W at the valve's opening `v`, which the model lacks. Its conductances
/// cannot be 0: microwatts across them would explain kelvins.
fn study() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("pump");
    fs::create_dir(&folder).unwrap();
    let model = r#"{"format": "bmv-network/1", "title": "A box on a plate",
      "inputs": {"Q": {"unit": "W", "nominal": 5, "range": [0, 20]}, "valve": {"unit": "%", "nominal": 50, "range": [0, 100]}},
      "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"lognormal": {"median": 0.5, "factor": 1.22}}, "source": "assumed"},
        "H": {"unit": "W/K", "nominal": 0.2, "prior": {"lognormal": {"median": 0.2, "factor": 1.28}}, "source": "assumed"}},
      "nodes": {"sink": {"boundary": "290"}, "plate": {"capacity": 200}, "box": {"capacity": 100}},
      "conductors": {"feet": {"between": ["plate", "sink"], "conductance": "G"}, "strap": {"between": ["box", "plate"], "conductance": "H"}},
      "loads": {"heater": {"into": "plate", "power": "Q"}}}"#;
    let pass = r#"{"format": "bmv-pass/1", "title": "Pump", "parent": null, "model": "model.json", "seed": 3,
      "measurements": {"test": {"steady": {"file": "data.csv", "sensors": {
        "plate": {"measures": "plate", "sigma": {"value": 0.1, "unit": "K"}},
        "box": {"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}}}}},
      "jobs": {"missing": {"diagnose": {}}}}"#;
    let mut noise = StreamKey::new(8, "pump", "noise").stream(0);
    let mut table = String::from("phase,Q [W],valve [%],plate [K],box [K]\n");
    for row in 0..21_u32 {
        let (q, valve) = (3.0 + f64::from(row * 8 % 21) * 0.7, 5.0 * f64::from(row));
        let pump = 2.0 * (1.0 - exp(-valve / 25.0));
        let plate = 290.0 + (q + pump) / 0.5;
        let read = [plate, plate + pump / 0.2].map(|value| value + 0.1 * noise.normal());
        table.push_str(&format!("P{row:02},{q},{valve},{:.4},{:.4}\n", read[0], read[1]));
    }
    for (name, text) in [("model.json", model), ("pass-1.json", pass), ("data.csv", &table)] {
        fs::write(folder.join(name), text).unwrap();
    }
    root
}

#[test]
#[ignore = "thorough"]
fn the_law_of_a_curve_is_named_and_adopted() {
    let root = study();
    let output: Value =
        serde_json::from_str(&printed(root.path(), &["diagnose", "pump/pass-1.json", "--json"])).unwrap();
    let result = &output;
    assert_eq!(result["selected"][0], "input-function-load:box:valve", "{}", result["words"]);
    let effects = result["effects"].as_array().unwrap();
    let law = effects.iter().find(|effect| effect["file"].is_object()).unwrap_or_else(|| panic!("{}", result["words"]));
    assert_eq!(law["id"], "saturating-load:box:valve", "{}", result["words"]);
    for (name, truth) in [("size", 2.0), ("scale", 0.25)] {
        let (value, sd) =
            (law["amplitudes"][name]["value"].as_f64().unwrap(), law["amplitudes"][name]["sd"].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * sd && sd < 0.2 * truth, "{name} {value} {sd}");
    }
    // What else is selected follows the curve's straight pieces.
    let others = result["selected"].as_array().unwrap().len() - 1;
    assert_eq!(law["file"]["needless"].as_array().map_or(0, Vec::len), others, "{law}");
    let words = result["words"].to_string();
    assert!(words.contains("bmv adopt PASS saturating-load:box:valve"), "{words}");

    // Not both.
    let both = ["adopt", "pump/pass-1.json", "saturating-load:box:valve", "input-function-load:box:valve"];
    assert_eq!(code(&bmv(root.path(), &both)), 2);
    let said = printed(root.path(), &["adopt", "pump/pass-1.json", "saturating-load:box:valve"]);
    assert!(said.contains("wrote effects/saturating-load.json"), "{said}");
    let adopted: Value =
        serde_json::from_str(&fs::read_to_string(root.path().join("pump/pass-2.json")).unwrap()).unwrap();
    assert!(adopted["adopt"].to_string().contains("saturating-load"), "{adopted}");
    let next: Value = serde_json::from_str(&printed(root.path(), &["diagnose", "pump/pass-2.json", "--json"])).unwrap();
    assert_eq!(next["verdict"], "adequate", "{}", next["words"]);
    // The same effect again is no second file.
    printed(root.path(), &["adopt", "pump/pass-1.json", "saturating-load:box:valve", "--out", "pump/mine.json"]);
    fs::write(root.path().join("pump/effects/saturating-load.json"), "{}").unwrap();
    let other =
        bmv(root.path(), &["adopt", "pump/pass-1.json", "saturating-load:box:valve", "--out", "pump/third.json"]);
    assert!(!other.status.success());
}
