//! What all thermometers of a test have in common is one effect with one size.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box on a plate on a sink",
  "inputs": {"Q": {"unit": "W", "nominal": 0, "range": [0, 30]}},
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.1}}, "source": "assumed"},
    "H": {"unit": "W/K", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.1}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "290"}, "plate": {"capacity": 100}, "box": {"capacity": 50}},
  "conductors": {"feet": {"between": ["plate", "sink"], "conductance": "G"}, "strap": {"between": ["box", "plate"], "conductance": "H"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}}
}"#;

const PASS: &str = r#"{"format": "bmv-pass/1", "title": "Logger", "parent": null, "model": "model.json", "seed": 3,
    "measurements": {"test": {"transient": {"file": "data.csv", "hold": ["Q"],
      "initial": {"temperatures": {"all": {"value": 290, "unit": "K"}}},
      "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.1, "unit": "K"}},
                  "box": {"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}}}}},
    "jobs": {"missing": {"diagnose": {}}}}"#;

const SIGMA_K: f64 = 0.1;

/// A heater that goes on and off, both thermometers following by first order with the same time constant: in steps of a
/// tenth of a second by Euler's rule, whose error is below 5 mK.
fn diagnosed(lag_s: f64) -> Output {
    let mut noise = StreamKey::new(5, "thermometers", "noise").stream(0);
    let mut table = String::from("time [s],Q [W],plate [K],box [K]\n");
    let (mut state, mut read) = ([290.0_f64; 2], [290.0_f64; 2]);
    for row in 0..120_u32 {
        let power = if row / 15 % 2 == 0 { 20.0 } else { 2.0 };
        let shown = read.map(|kelvin| kelvin + SIGMA_K * noise.normal());
        table.push_str(&format!("{},{power},{:.4},{:.4}\n", 20 * row, shown[0], shown[1]));
        for _ in 0..200 {
            let [plate, cabinet] = state;
            let through = 0.5 * (plate - cabinet);
            state[0] += 0.1 * (power - 0.5 * (plate - 290.0) - through) / 100.0;
            state[1] += 0.1 * through / 50.0;
            for (read, kelvin) in read.iter_mut().zip(state) {
                *read += 0.1 * (kelvin - *read) / lag_s.max(0.1);
            }
        }
    }
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", PASS)]);
    let key = StreamKey::new(7, "thermometers", "diagnosis");
    Diagnosis::new(problem, Settings::default(), key).run().expect("a diagnosis")
}

#[test]
#[ignore = "thorough"]
fn a_lag_of_all_thermometers_is_one_effect() {
    let output = diagnosed(25.0);
    assert_eq!(output.selected, ["sensor-lag:all thermometers"], "{:?}", output.words);
    let effect = output.effects.iter().find(|effect| effect.id == output.selected[0]).expect("listed");
    let constant = &effect.amplitudes["time_constant"];
    assert!((constant.value - 25.0).abs() < 4.0 * constant.sd && constant.sd < 1.0, "{constant:?}");
    // One size explains both: a lag of one thermometer does not.
    for other in output.effects.iter().filter(|other| other.id != effect.id) {
        // Heat that arrives late looks like it where the readings show little but the heater's steps.
        let most = if other.effect == "heater-capacity" { 0.1 } else { 0.05 };
        assert!(other.probability < most, "{} {}: {:?}", other.id, other.probability, output.words);
    }
}

#[test]
fn thermometers_that_follow_at_once_have_no_lag() {
    let output = diagnosed(0.0);
    assert_eq!(output.selected, Vec::<String>::new(), "{:?}", output.words);
}
