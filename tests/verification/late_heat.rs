//! Heat that arrives late and a sensor beside the heater, as networks by hand: found among the whole catalogue.

use bmv::diagnosis::{Output, Verdict};
use bmv::random::StreamKey;

use super::small_study;

/// A plate on a cold sink under a heater; a box hangs on it.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A heated plate and a box",
  "inputs": {"T_sink": {"unit": "K", "nominal": 280, "range": [260, 300]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 20]},
    "P": {"unit": "W", "nominal": 1, "range": [0, 20]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.3, 0.7]}, "source": "assumed"},
    "G_b": {"unit": "W/K", "nominal": 0.3, "prior": {"uniform": [0.2, 0.4]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "plate": {"capacity": 200}, "box": {"capacity": 150}},
  "conductors": {
    "feet": {"between": ["plate", "sink"], "conductance": "G"},
    "joint": {"between": ["plate", "box"], "conductance": "G_b"}
  },
  "loads": {"heater": {"into": "plate", "power": "Q"}, "electronics": {"into": "box", "power": "P"}}
}"#;
/// Sigma of the sensors, K.
const NOISE_K: f64 = 0.05;

/// The diagnosis of a record of steps in both loads. `heater` is the capacity, J/K, of what dissipates `Q` and its conductance,
/// W/K, to the plate; `excess` is what the plate's sensor reads too much, K/W.
fn diagnosed(heater: Option<[f64; 2]>, excess: f64) -> Output {
    let mut stream = StreamKey::new(29, "late heat", "noise").stream(0);
    let mut table = String::from("time [s],T_sink [K],Q [W],P [W],plate [K],box [K]\n");
    let (mut hot, mut plate, mut inner) = (280.0_f64, 280.0_f64, 280.0_f64);
    let power = |second: usize| [[0.0, 12.0, 4.0, 16.0, 0.0][second / 1500 % 5], [0.0, 8.0, 2.0][second / 1080 % 3]];
    // Loads step in rows. By hand, in steps of a tenth of a second: first-order errors are below a thousandth of a step's rise.
    for second in 0..=9000_usize {
        let [q, p] = power(second);
        if second.is_multiple_of(60) {
            // A reading at a step belongs to what was before it: offset in time it would be otherwise, by less than a row.
            let before = power(second.saturating_sub(1))[0];
            let read = [plate + excess * before, inner].map(|value| value + NOISE_K * stream.normal());
            table.push_str(&format!("{second},280,{q},{p},{:e},{:e}\n", read[0], read[1]));
        }
        for _ in 0..10 {
            let arrives = heater.map_or(q, |[_, conductance]| conductance * (hot - plate));
            let through = 0.3 * (inner - plate);
            hot += heater.map_or(0.0, |[capacity, _]| 0.1 * (q - arrives) / capacity);
            let into_plate = arrives + through - 0.5 * (plate - 280.0);
            (plate, inner) = (plate + 0.1 * into_plate / 200.0, inner + 0.1 * (p - through) / 150.0);
        }
    }
    let sensor =
        |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": {NOISE_K}, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Steps", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"transient": {{"file": "data.csv", "hold": ["Q", "P"],
            "initial": {{"temperatures": {{"all": {{"value": 280, "unit": "K"}}}}}}, "sensors": {{{}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        sensor("plate"),
        sensor("box")
    );
    let folder = tempfile::tempdir().expect("a folder");
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

/// Whether an amplitude of a selected effect lies within four standard deviations of the truth.
fn is_found(output: &Output, id: &str, amplitude: &str, truth: f64) {
    let effect = output.effects.iter().find(|own| own.id == id).unwrap_or_else(|| panic!("{:?}", output.words));
    let own = &effect.amplitudes[amplitude];
    assert!((own.value - truth).abs() < 4.0 * own.sd, "{id}: {} ± {}, in truth {truth}", own.value, own.sd);
}

#[test]
#[ignore = "thorough"]
fn a_heater_that_warms_up_first_is_named() {
    let output = diagnosed(Some([80.0, 0.4]), 0.0);
    assert_eq!(output.selected, ["heater-capacity:heater"], "{:?}", output.words);
    assert_eq!(output.verdict, Verdict::Identified, "{:?}", output.words);
    is_found(&output, "heater-capacity:heater", "capacity", 80.0);
    is_found(&output, "heater-capacity:heater", "conductance", 0.4);
}

#[test]
#[ignore = "thorough"]
fn a_sensor_beside_the_heater_is_named() {
    let output = diagnosed(None, 0.1);
    assert_eq!(output.selected, ["sensor-gradient:plate:Q"], "{:?}", output.words);
    is_found(&output, "sensor-gradient:plate:Q", "excess", 0.1);
}

/// Heat of which nothing arrives within the run is not late: no heat capacity explains that a heater is off.
#[test]
#[ignore = "thorough"]
fn a_heater_that_is_off_has_no_heat_capacity() {
    let output = diagnosed(Some([1e9, 1e-6]), 0.0);
    let late = output.effects.iter().filter(|own| own.effect == "heater-capacity");
    let late: f64 = late.map(|own| own.probability).sum();
    assert!(late < 0.01, "{late}: {:?}", output.words);
    assert_eq!(output.selected, ["input-proportional-load:plate:Q"], "{:?}", output.words);
}
