//! Joints that change at a threshold. A transient: by hand, in exponential pieces, far from the middle of the temperatures that
//! nodes may have. Steady phases: by hand, with a reading that puts the threshold into the wrong gap between two levels.

use std::sync::Arc;

use bmv::diagnosis::{Diagnosis, Problem, Settings};
use bmv::math::functions::{exp, ln};
use bmv::random::StreamKey;

use super::small_study;

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

fn problem(table: &str, pass: &str) -> Problem {
    let mut problem = small_study::problem(&[("model.json", MODEL), ("data.csv", table), ("pass-1.json", pass)]);
    let rivals =
        ["conductance-step", "temperature-dependent-conductance", "heat-load", "heater-efficiency", "thermal-mass"];
    Arc::make_mut(&mut problem.candidates).retain(|own| rivals.contains(&own.effect.as_str()));
    problem
}

fn transient() -> Problem {
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
    problem(&table, pass)
}

/// Power above which the joint of the steady phases conducts 3 % less, W.
const STEP: f64 = 15.9;
/// Powers that are held out: just above a level, below the step.
const HELD_OUT: [f64; 8] = [15.3, 15.35, 15.4, 15.45, 15.5, 15.55, 15.6, 15.65];

/// Four phases at each of the powers 3, 6, ... 30 W, but one at 15 W, whose reading is `off` kelvin too high; noise of 0.3 K as
/// plus and minus 0.2 K, with the sign of the bits of a number.
fn steady(off: f64) -> Problem {
    let mut table = String::from("phase,Q [W],sink [K],plate [K]\n");
    let mut row = 0_u32;
    let mut add = |q: f64, extra: f64| {
        row += 1;
        let conductance = if q > STEP { 0.485 } else { 0.5 };
        let noise = if 0b1_0110_0101_1010_0110_1001_0101_1010 >> (row % 31) & 1 == 1 { 0.2 } else { -0.2 };
        let error = if extra == 0.0 { noise } else { extra };
        table.push_str(&format!("P{row:02},{q},290,{:.4}\n", 290.0 + q / conductance + error));
    };
    for level in 1..=10 {
        for _ in 0..if level == 5 { 1 } else { 4 } {
            add(3.0 * f64::from(level), if level == 5 { off } else { 0.0 });
        }
    }
    HELD_OUT.iter().for_each(|&q| add(q, 0.0));
    let pass = r#"{"format": "bmv-pass/1", "title": "Step", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"test": {"steady": {"file": "data.csv",
          "held_out": {"phases": ["P38", "P39", "P40", "P41", "P42", "P43", "P44", "P45"]},
          "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.3, "unit": "K"}}}}}},
        "jobs": {"missing": {"diagnose": {}}}}"#;
    let mut problem = problem(&table, pass);
    // What bends little by little, and the plate that gets warmer with the power, would do nearly as well.
    Arc::make_mut(&mut problem.candidates).retain(|own| own.id == "conductance-step:joint:Q");
    problem
}

#[test]
fn a_threshold_is_sought_where_the_temperatures_of_a_transient_are() {
    let key = StreamKey::new(6, "threshold", "diagnosis");
    let output = Diagnosis::new(transient(), Settings::default(), key).run().expect("a diagnosis");
    assert_eq!(output.selected, ["conductance-step:joint:plate"], "{:?}", output.words);
    let amounts = &output.effects[0].amplitudes;
    // Three of the standard deviations that so sharp a step leaves of the threshold, and of the change.
    assert!((amounts["threshold"].value - THRESHOLD).abs() < 1.0, "{amounts:?}");
    assert!((amounts["change"].value + 0.5).abs() < 0.02, "{amounts:?}");
}

/// At 15 W the joint has not changed: 30 K above the sink. A reading of 30.7 K is rather that of a changed joint (30.93 K), and then the
/// threshold lies between 12 and 15 W; above 15 W the held-out phases tell that it has not been crossed.
#[test]
fn held_out_phases_place_a_threshold_that_the_fitted_ones_leave_open() {
    let diagnose = |off: f64| {
        let key = StreamKey::new(6, "threshold", "diagnosis");
        Diagnosis::new(steady(off), Settings::default(), key).run().expect("a diagnosis")
    };
    let is_said =
        |output: &bmv::diagnosis::Output| output.warnings.iter().any(|said| said.contains("a threshold lies"));
    for off in [0.1, 0.7] {
        let output = diagnose(off);
        assert_eq!(output.selected, ["conductance-step:joint:Q"], "{off}: {:?} {:?}", output.words, output.warnings);
        let threshold = &output.effects[0].amplitudes["threshold"];
        assert!(15.0 < threshold.most_probable && threshold.most_probable < 18.0, "{off}: {threshold:?}");
        assert_eq!(is_said(&output), off > 0.3, "{off}: {:?}", output.warnings);
        assert_eq!(output.held_out_test, None, "all held-out rows lie in the gap, {off}");
    }
}
