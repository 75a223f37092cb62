//! A room between neighbours that are warmer than the outdoor air, which alone was logged: heavy walls would read the same.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::math::functions::sin;
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A heated room",
  "inputs": {"outdoor": {"unit": "degC", "nominal": 4, "range": [-10, 15]}, "P": {"unit": "W", "nominal": 300, "range": [0, 1500]}},
  "parameters": {
    "C": {"unit": "J/K", "nominal": 1e6, "prior": {"loguniform": [2e5, 2e7]}, "source": "assumed"},
    "G": {"unit": "W/K", "nominal": 20, "prior": {"loguniform": [4, 100]}, "source": "assumed"}},
  "nodes": {"outside": {"boundary": "outdoor"}, "air": {"capacity": "C"}},
  "conductors": {"envelope": {"between": ["air", "outside"], "conductance": "G"}},
  "loads": {"heater": {"into": "air", "power": "P"}}
}"#;

/// Conductance to the neighbours, W/K, and their temperature, degC.
const TO_NEIGHBOURS: f64 = 60.0;
const NEIGHBOURS_DEGC: f64 = 18.0;

/// Four days in steps of a minute by Euler's rule, inputs held over half an hour, the last day held out.
fn diagnosed() -> Output {
    let mut noise = StreamKey::new(3, "room", "noise").stream(0);
    let mut table = String::from("time [s],outdoor [degC],P [W],air [degC]\n");
    let mut air: f64 = 19.0;
    for minute in 0..=4 * 1440_u32 {
        let held = minute / 30;
        let day = f64::from(held) / 48.0;
        let outdoor = 4.0 + 3.0 * sin(day * 2.0 * std::f64::consts::PI) + day;
        let power: f64 = if held * 5 / 7 % 3 == 0 { 1200.0 } else { 0.0 };
        if minute.is_multiple_of(30) {
            table.push_str(&format!("{},{outdoor:.4},{power},{:.4}\n", 60 * minute, air + 0.05 * noise.normal()));
        }
        let into = power - 20.0 * (air - outdoor) - TO_NEIGHBOURS * (air - NEIGHBOURS_DEGC);
        air += 60.0 * into / 1e6;
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "Room", "parent": null, "model": "model.json", "seed": 3,
      "measurements": {"days": {"transient": {"file": "data.csv", "hold": ["outdoor", "P"],
        "initial": {"temperatures": {"air": {"value": 19, "unit": "degC"}}},
        "sensors": {"air": {"measures": "air", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 3}}, "unit": "K"}}},
        "held_out": {"intervals": [{"from": {"value": 3, "unit": "d"}}]}}}},
      "jobs": {"missing": {"diagnose": {}}}}"#;
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", &table), ("pass-1.json", pass)]);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "room", "diagnosis")).run().expect("a diagnosis")
}

#[test]
#[ignore = "thorough"]
fn a_store_of_heat_is_named_beside_surroundings_that_nothing_logged_keeps_warm() {
    let output = diagnosed();
    let find = |id: &str| output.effects.iter().find(|own| own.id == id);
    let of = find("path-to-ambient:air").unwrap_or_else(|| panic!("{:?}", output.words));
    let temperature = &of.amplitudes["temperature"];
    assert!((temperature.value - NEIGHBOURS_DEGC).abs() < 4.0 * temperature.sd.max(0.02), "{temperature:?}");
    let store = find("hidden-node:air").unwrap_or_else(|| panic!("{:?}", output.words));
    assert!(store.group == Some(1) && of.group == Some(1), "{:?}", output.words);
    assert!(store.probability > 0.2 && store.probability <= 0.5, "{}", store.probability);
}
