//! A fit that a missing effect draws to where the model is far from linear: a box that is believed to lose nothing, whose capacity
//! the fit makes so large that no loss shows in the linearisation there. The loss is tried in any case.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box and its heater",
  "inputs": {"Q": {"unit": "W", "nominal": 0, "range": [0, 20]}},
  "parameters": {
    "C_heater": {"unit": "J/K", "nominal": 20, "prior": {"loguniform": [5, 100]}, "source": "assumed"},
    "C_box": {"unit": "J/K", "nominal": 100, "prior": {"loguniform": [20, 5000]}, "source": "assumed"},
    "G": {"unit": "W/K", "nominal": 0.3, "prior": {"loguniform": [0.05, 3]}, "source": "assumed"}},
  "nodes": {"heater": {"capacity": "C_heater"}, "box": {"capacity": "C_box"}},
  "conductors": {"air": {"between": ["heater", "box"], "conductance": "G"}},
  "loads": {"power": {"into": "heater", "power": "Q"}}
}"#;

/// Two hours: 10 W for twenty minutes in each forty, and the box loses 0.25 W/K to a room at 21 degC; in steps of half a second by
/// Euler's rule. The noise is not stated.
fn diagnosed() -> Output {
    let mut noise = StreamKey::new(12, "bent", "noise").stream(0);
    let mut table = String::from("time [s],Q [W],heater [degC],box [degC]\n");
    let (mut heater, mut inside) = (21.0, 21.0);
    for half in 0..=14_400_u32 {
        let q = if (half / 2400).is_multiple_of(2) { 10.0 } else { 0.0 };
        if half.is_multiple_of(40) {
            let read = [heater, inside].map(|value: f64| value + 0.1 * noise.normal());
            table.push_str(&format!("{},{q},{:.4},{:.4}\n", 0.5 * f64::from(half), read[0], read[1]));
        }
        let through = 0.2 * (heater - inside);
        heater += 0.5 * (q - through) / 25.0;
        inside += 0.5 * (through - 0.25 * (inside - 21.0)) / 90.0;
    }
    let sensor = |name: &str| {
        format!(
            r#""{name}": {{"measures": "{name}", "sigma": {{"prior": {{"lognormal": {{"median": 0.3, "factor": 3}}}}, "unit": "K"}}}}"#
        )
    };
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Box that loses heat", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"transient": {{"file": "data.csv", "hold": ["Q"],
            "initial": {{"temperatures": {{"all": {{"value": 21, "unit": "degC"}}}}}}, "sensors": {{{}, {}}},
            "held_out": {{"intervals": [{{"from": {{"value": 5400, "unit": "s"}}}}]}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        sensor("heater"),
        sensor("box")
    );
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", &table), ("pass-1.json", &pass)]);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "bent", "diagnosis")).run().expect("a diagnosis")
}

#[test]
#[ignore = "thorough"]
fn a_loss_of_a_box_that_is_believed_adiabatic_is_among_the_first_steps_rivals() {
    let output = diagnosed();
    let step = output.steps.first().expect("a step");
    let loses =
        |id: &String| ["path-to-ambient:box", "free-convection:box", "radiation-to-ambient:box"].contains(&id.as_str());
    assert!(step.effect.iter().chain(&step.alternatives).any(loses), "{step:?} {:?}", output.words);
}
