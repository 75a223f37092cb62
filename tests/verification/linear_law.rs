//! A linear law of temperature is out of range where it leaves nothing of what it changes.

use bmv::diagnosis::fits::refit::Begin;
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A board on a sink",
  "inputs": {"T_sink": {"unit": "K", "nominal": 290, "range": [250, 320]}, "P": {"unit": "W", "nominal": 10, "range": [0, 200]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.45, 0.55]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "board": {}},
  "conductors": {"feet": {"between": ["board", "sink"], "conductance": "G"}},
  "loads": {"electronics": {"into": "board", "power": "P"}}
}"#;
/// Conductance of the feet, W/K.
const FEET: f64 = 0.5;
const NOISE_K: f64 = 0.02;

/// How many values are out of range in the fit of phases in which the dissipation falls by `fall` (1/K) of what it has at 293.15 K, at
/// `scale` of the usual powers; and the least share of the power that is left.
fn out_of_range(fall: f64, scale: f64) -> (usize, f64) {
    let mut stream = StreamKey::new(31, "linear law", "noise").stream(0);
    let mut table = String::from("phase,T_sink [K],P [W],board [K]\n");
    let mut least = f64::INFINITY;
    for phase in 0..18_usize {
        let sink = [270.0, 290.0, 305.0][phase % 3];
        let power = scale * [2.0, 10.0, 20.0, 32.0, 46.0, 60.0][phase / 3];
        // The balance G (T - Ts) = P (1 - b (T - 293.15)), solved for T.
        let board = (FEET * sink + power * (1.0 + fall * 293.15)) / (FEET + power * fall);
        least = least.min(1.0 - fall * (board - 293.15));
        table.push_str(&format!("P{phase:02},{sink},{power},{:e}\n", board + NOISE_K * stream.normal()));
    }
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Phases", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"steady": {{"file": "data.csv",
            "sensors": {{"board": {{"measures": "board", "sigma": {{"value": {NOISE_K}, "unit": "K"}}}}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#
    );
    let problem =
        small_study::problem(&[("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())]);
    let law = problem.candidates.iter().position(|own| own.id == "dissipation-temperature:electronics").unwrap();
    let begin = Begin { from_prior: 4, scale: 1.0, ..Begin::default() };
    let refit = problem.refit(&[law], &begin, &StreamKey::new(1, "test", "linear law")).unwrap();
    let coefficient = &refit.amplitudes[0][0];
    assert!((coefficient.mode + fall).abs() < 0.01 * fall, "{coefficient:?}");
    (problem.values_out_of_range(&refit), least)
}

#[test]
fn a_dissipation_that_falls_by_half_is_in_range_and_one_that_falls_to_nothing_is_not() {
    let (moderate, left) = out_of_range(0.008, 1.0);
    assert!(moderate == 0 && left > 0.3, "{moderate} {left}");
    let (nothing, left) = out_of_range(0.06, 2.0);
    assert!(nothing == 1 && left < 0.1, "{nothing} {left}");
}
