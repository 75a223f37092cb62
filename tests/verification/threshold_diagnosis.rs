//! A transient whose joint changes at a threshold: by hand, in exponential pieces, far from the middle of the temperatures that
//! nodes may have.

use std::path::Path;

use bmv::diagnosis::{Diagnosis, Problem, Settings};
use bmv::math::functions::{exp, ln};
use bmv::random::StreamKey;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A plate on a sink",
  "inputs": {"Q": {"unit": "W", "nominal": 0, "range": [0, 30]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.45, "prior": {"normal": {"mean": 0.45, "sd": 0.1}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "290"}, "plate": {"capacity": 200}},
  "conductors": {"joint": {"between": ["plate", "sink"], "conductance": "G"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}}
}"#;

/// The catalogue's step is spread over 4 K, through which the plate passes in about 40 s: with 0.2 K the difference would show.
const SIGMA: f64 = 0.5;
const THRESHOLD: f64 = 322.0;

/// Temperature of the plate, K: 25 W until 1500 s, then none; 0.5 W/K to the sink below the threshold and 0.25 W/K above.
fn plate(t: f64) -> f64 {
    let up = 400.0 * ln(50.0 / (340.0 - THRESHOLD));
    let above = |t: f64| 390.0 - (390.0 - THRESHOLD) * exp(-(t - up) / 800.0);
    let down = 1500.0 + 800.0 * ln((above(1500.0) - 290.0) / (THRESHOLD - 290.0));
    match t {
        t if t < up => 340.0 - 50.0 * exp(-t / 400.0),
        t if t < 1500.0 => above(t),
        t if t < down => 290.0 + (above(1500.0) - 290.0) * exp(-(t - 1500.0) / 800.0),
        t => 290.0 + (THRESHOLD - 290.0) * exp(-(t - down) / 400.0),
    }
}

fn problem(folder: &Path) -> Problem {
    let mut noise = StreamKey::new(5, "threshold", "noise").stream(0);
    let mut table = String::from("time [s],Q [W],plate [K]\n");
    for row in 0..=120 {
        let t = 25.0 * f64::from(row);
        let q = if t < 1500.0 { 25.0 } else { 0.0 };
        table.push_str(&format!("{t},{q},{:.6}\n", plate(t) + SIGMA * noise.normal()));
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "Step", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"test": {"transient": {"file": "data.csv", "hold": ["Q"],
          "initial": {"temperatures": {"all": 290}}, "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.5, "unit": "K"}}}}}},
        "jobs": {"missing": {"diagnose": {}}}}"#;
    for (name, text) in [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass)] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    let pass = bmv::study::load(&folder.join("pass-1.json"));
    let mut problem = bmv::study::problem(&pass.unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20))));
    let rivals =
        ["conductance-step", "temperature-dependent-conductance", "heat-load", "heater-efficiency", "thermal-mass"];
    problem.candidates.retain(|own| rivals.contains(&own.effect.as_str()));
    problem
}

#[test]
fn a_threshold_is_sought_where_the_temperatures_of_a_transient_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let key = StreamKey::new(6, "threshold", "diagnosis");
    let output = Diagnosis::new(problem(folder.path()), Settings::default(), key).run().expect("a diagnosis");
    assert_eq!(output.selected, ["conductance-step:joint:plate"], "{:?}", output.words);
    let amounts = &output.effects[0].amplitudes;
    // Three of the standard deviations that so sharp a step leaves of the threshold, and of the change.
    assert!((amounts["threshold"].value - THRESHOLD).abs() < 1.0, "{amounts:?}");
    assert!((amounts["change"].value + 0.5).abs() < 0.02, "{amounts:?}");
}
