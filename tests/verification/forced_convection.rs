//! A fan that makes a loss six times as large: a change ten standard deviations beyond the written prior, whose fit begins far out, and
//! which is within one of ten times as wide.

use bmv::diagnosis::{Diagnosis, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box in a room",
  "inputs": {
    "P": {"unit": "W", "nominal": 5, "range": [0, 20]},
    "fan": {"unit": "1", "nominal": 0, "range": [0, 1]}},
  "parameters": {
    "C": {"unit": "J/K", "nominal": 600, "prior": {"lognormal": {"median": 600, "factor": 2}}, "source": "assumed"},
    "G": {"unit": "W/K", "nominal": 0.4, "prior": {"lognormal": {"median": 0.4, "factor": 2}}, "source": "assumed"}},
  "nodes": {"room": {"boundary": "295"}, "box": {"capacity": "C"}},
  "conductors": {"to room": {"between": ["box", "room"], "conductance": "G"}},
  "loads": {"heater": {"into": "box", "power": "P"}}
}"#;

const PASS: &str = r#"{"format": "bmv-pass/1", "title": "Fan", "parent": null, "model": "model.json", "seed": 3,
    "measurements": {"log": {"transient": {"file": "log.csv", "hold": ["P", "fan"],
      "initial": {"temperatures": {"all": {"value": 295, "unit": "K"}}},
      "sensors": {"box": {"measures": "box", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 3}}, "unit": "K"}}}}}},
    "jobs": {"missing": {"diagnose": {}}}}"#;

#[test]
#[ignore = "thorough"]
fn a_fan_is_no_hundred_times_what_is_plausible() {
    let mut noise = StreamKey::new(1, "box", "noise").stream(0);
    let (mut table, mut node) = (String::from("time [s],P [W],fan [1],box [K]\n"), 295.0);
    for step in 0..2400 {
        let power = if step / 300 % 2 == 0 { 10.0 } else { 4.0 };
        let fan = if step / 500 % 2 == 0 { 0.0 } else { 1.0 };
        if step % 12 == 0 {
            table.push_str(&format!("{},{power},{fan},{:.4}\n", 10 * step, node + 0.05 * noise.normal()));
        }
        node += 10.0 * (power - 0.4 * (1.0 + 5.0 * fan) * (node - 295.0)) / 600.0;
    }
    let problem = small_study::problem(&[("model.json", MODEL), ("log.csv", &table), ("pass-1.json", PASS)]);
    let output = Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "fan", "diagnosis")).run().unwrap();
    let is_of_fan =
        |id: &str| ["input-dependent-conductance:to room:fan", "conductance-step:to room:fan"].contains(&id);
    let found = output.effects.iter().find(|effect| is_of_fan(&effect.id)).expect("it was fitted");
    assert!(output.selected.contains(&found.id), "{:?}", output.words);
    let size = &found.amplitudes["change"];
    assert!((size.value - 5.0).abs() < 3.0 * size.sd, "{size:?}");
    assert!(found.prior_width <= 10.0 && found.model_error < 0.5, "{found:?}");
}
