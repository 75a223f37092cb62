//! A plate and a box in a room that warms while they are tested, and of which one temperature was noted.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A plate and a box in a room",
  "inputs": {"T_room": {"unit": "degC", "nominal": 20, "range": [15, 30]}, "P": {"unit": "W", "nominal": 5, "range": [0, 10]}},
  "parameters": {
    "G_plate": {"unit": "W/K", "nominal": 0.3, "prior": {"uniform": [0.15, 0.6]}, "source": "assumed"},
    "G_box": {"unit": "W/K", "nominal": 0.2, "prior": {"uniform": [0.1, 0.4]}, "source": "assumed"},
    "G_strap": {"unit": "W/K", "nominal": 0.1, "prior": {"uniform": [0.05, 0.2]}, "source": "assumed"}},
  "nodes": {"room": {"boundary": "T_room"}, "plate": {"capacity": 400}, "box": {"capacity": 250}},
  "conductors": {
    "feet": {"between": ["plate", "room"], "conductance": "G_plate"},
    "mount": {"between": ["box", "room"], "conductance": "G_box"},
    "strap": {"between": ["plate", "box"], "conductance": "G_strap"}},
  "loads": {"heater": {"into": "plate", "power": "P"}}
}"#;

/// By which the room warms, K/s: about a kelvin in an hour.
const DRIFT: f64 = 3e-4;

/// Four hours in steps of a second by Euler's rule, the heater on in every other half hour, the last forty minutes held out.
fn diagnosed() -> Output {
    let mut noise = StreamKey::new(5, "drifting room", "noise").stream(0);
    let mut table = String::from("time [s],T_room [degC],P [W],plate [degC],box [degC]\n");
    let (mut plate, mut case) = (20.0_f64, 20.0_f64);
    for second in 0..=14_400_u32 {
        let power = if second / 1800 % 2 == 1 { 5.0 } else { 0.0 };
        if second.is_multiple_of(120) {
            let [of_plate, of_box] = [plate, case].map(|value| value + 0.05 * noise.normal());
            table.push_str(&format!("{second},20,{power},{of_plate:.4},{of_box:.4}\n"));
        }
        let room = 20.0 + DRIFT * f64::from(second);
        let across = 0.1 * (plate - case);
        plate += (power - 0.3 * (plate - room) - across) / 400.0;
        case += (across - 0.2 * (case - room)) / 250.0;
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "Room", "parent": null, "model": "model.json", "seed": 3,
      "measurements": {"test": {"transient": {"file": "data.csv", "hold": ["P"],
        "initial": {"temperatures": {"all": {"value": 20, "unit": "degC"}}},
        "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.05, "unit": "K"}},
          "box": {"measures": "box", "sigma": {"value": 0.05, "unit": "K"}}},
        "held_out": {"intervals": [{"from": {"value": 200, "unit": "min"}}]}}}},
      "jobs": {"missing": {"diagnose": {}}}}"#;
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", &table), ("pass-1.json", pass)]);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "drifting room", "diagnosis"))
        .run()
        .expect("a diagnosis")
}

#[test]
#[ignore = "thorough"]
fn a_room_that_warms_is_named_with_its_rate() {
    let output = diagnosed();
    assert_eq!(output.selected, ["sink-drift:room"], "{:?}", output.words);
    let of = output.effects.iter().find(|own| own.id == "sink-drift:room").expect("selected");
    let drift = &of.amplitudes["drift"];
    assert!((drift.value - DRIFT).abs() < 4.0 * drift.sd && drift.sd < 0.1 * DRIFT, "{drift:?}");
    let held_out = of.rmse_k.held_out[1].expect("held-out rows");
    assert!(held_out < 0.07, "{held_out} K beside a noise of 0.05 K");
}
