//! A node whose wax melts, by the enthalpy method by hand: found among the whole catalogue.

use bmv::diagnosis::{Output, Verdict};
use bmv::random::StreamKey;

use super::small_study;

/// A box on a cold plate, and a radiator behind it.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box with a heater",
  "inputs": {"T_sink": {"unit": "K", "nominal": 280, "range": [260, 300]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 40]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.3, 0.7]}, "source": "assumed"},
    "C": {"unit": "J/K", "nominal": 400, "prior": {"uniform": [300, 500]}, "source": "assumed"},
    "G_r": {"unit": "W/K", "nominal": 0.2, "prior": {"uniform": [0.1, 0.4]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "box": {"capacity": "C"}, "radiator": {"capacity": 150}},
  "conductors": {
    "feet": {"between": ["box", "sink"], "conductance": "G"},
    "joint": {"between": ["box", "radiator"], "conductance": "G_r"},
    "mount": {"between": ["radiator", "sink"], "conductance": 0.1}
  },
  "loads": {"heater": {"into": "box", "power": "Q"}}
}"#;
/// Sigma of the sensors, K.
const NOISE_K: f64 = 0.05;
/// Heat that melts the wax, J, and where, K.
const LATENT_J: f64 = 8000.0;
const MELTING_K: f64 = 301.0;

/// Temperature of the box by what it holds beyond 280 K, J: 400 J/K, and the wax.
fn temperature(held_j: f64) -> f64 {
    let melts_at = 400.0 * (MELTING_K - 280.0);
    280.0 + (held_j.min(melts_at) + (held_j - melts_at - LATENT_J).max(0.0)) / 400.0
}

fn diagnosed() -> Output {
    let mut stream = StreamKey::new(31, "wax", "noise").stream(0);
    let mut table = String::from("time [s],T_sink [K],Q [W],box [K],radiator [K]\n");
    let (mut held_j, mut radiator) = (0.0_f64, 280.0_f64);
    let power = |second: usize| [0.0, 20.0, 30.0, 6.0, 24.0, 0.0][second / 2400 % 6];
    for second in 0..=14_400_usize {
        let (q, inside) = (power(second), temperature(held_j));
        if second.is_multiple_of(60) {
            let read = [inside, radiator].map(|value| value + NOISE_K * stream.normal());
            table.push_str(&format!("{second},280,{q},{:e},{:e}\n", read[0], read[1]));
        }
        let through = 0.2 * (inside - radiator);
        held_j += q - 0.5 * (inside - 280.0) - through;
        radiator += (through - 0.1 * (radiator - 280.0)) / 150.0;
    }
    let sensor =
        |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": {NOISE_K}, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Wax", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"transient": {{"file": "data.csv", "hold": ["Q"],
            "initial": {{"temperatures": {{"all": {{"value": 280, "unit": "K"}}}}}}, "sensors": {{{}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        sensor("box"),
        sensor("radiator")
    );
    let folder = tempfile::tempdir().expect("a folder");
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

/// The law spreads the melting over a kelvin or less where the wax melts at one temperature: sizes are nearly those of the truth.
#[test]
fn wax_that_melts_is_named_with_its_temperature() {
    let output = diagnosed();
    assert_eq!(output.selected.first().map(String::as_str), Some("latent-heat:box:box"), "{:?}", output.words);
    assert_ne!(output.verdict, Verdict::Unexplained, "{:?}", output.words);
    let effect = output.effects.iter().find(|own| own.id == "latent-heat:box:box").expect("listed");
    assert!((effect.amplitudes["latent"].value - LATENT_J).abs() < 0.05 * LATENT_J, "{:?}", effect.amplitudes);
    assert!((effect.amplitudes["melting"].value - MELTING_K).abs() < 0.5, "{:?}", effect.amplitudes);
}
