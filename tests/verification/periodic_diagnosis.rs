//! Heat that goes round with an angle in steady phases, and with the time of day in a transient, by hand.

use bmv::diagnosis::{Diagnosis, Output, Problem, Settings};
use bmv::math::functions::{cos, sin};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box on a plate on a sink",
  "inputs": {"Q": {"unit": "W", "nominal": 0, "range": [0, 30]}, "roll": {"unit": "deg", "nominal": 0, "range": [0, 360]}},
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.1}}, "source": "assumed"},
    "H": {"unit": "W/K", "nominal": 0.2, "prior": {"normal": {"mean": 0.2, "sd": 0.05}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "290"}, "plate": {"capacity": 20000}, "box": {"capacity": 5000}},
  "conductors": {"feet": {"between": ["plate", "sink"], "conductance": "G"}, "strap": {"between": ["box", "plate"], "conductance": "H"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}}
}"#;

const SIGMA: f64 = 0.2;

const SENSORS: &str = r#""sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.2, "unit": "K"}},
    "box": {"measures": "box", "sigma": {"value": 0.2, "unit": "K"}}}"#;

fn studied(table: &str, measurement: &str) -> Problem {
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Turns", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {measurement}}}, "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#
    );
    small_study::problem(&[("model.json", MODEL), ("data.csv", table), ("pass-1.json", &pass)])
}

fn diagnosed(table: &str, measurement: &str) -> (Problem, Output) {
    let problem = studied(table, measurement);
    let key = StreamKey::new(7, "turns", "diagnosis");
    let output = Diagnosis::new(problem.clone(), Settings::default(), key).run().expect("a diagnosis");
    (problem, output)
}

/// Sixteen phases of a full turn; the sun warms the box by 0.4 cos x - 0.7 sin x W.
#[test]
fn heat_by_an_angle_is_found_with_its_two_parts() {
    let mut noise = StreamKey::new(8, "turns", "noise").stream(0);
    let mut table = String::from("phase,Q [W],roll [deg],plate [K],box [K]\n");
    for row in 0..16_u32 {
        let (q, roll) = (3.0 + f64::from(row * 7 % 16), 22.5 * f64::from(row * 5 % 16));
        let angle = roll.to_radians();
        let sun = 0.4 * cos(angle) - 0.7 * sin(angle);
        let plate = 290.0 + (q + sun) / 0.5;
        let cabinet = plate + sun / 0.2;
        let read = [plate, cabinet].map(|value| value + SIGMA * noise.normal());
        table.push_str(&format!("P{row:02},{q},{roll},{:.4},{:.4}\n", read[0], read[1]));
    }
    let (problem, output) = diagnosed(&table, &format!(r#"{{"steady": {{"file": "data.csv", {SENSORS}}}}}"#));
    assert!(problem.candidates.iter().all(|candidate| candidate.effect != "daily-load"), "phases have no time of day");
    assert_eq!(output.selected, ["periodic-load:box:roll"], "{:?}", output.words);
    let sizes = &output.effects[0].amplitudes;
    for (part, truth) in [("cosine", 0.4), ("sine", -0.7)] {
        // Four standard deviations.
        assert!((sizes[part].value - truth).abs() < 4.0 * sizes[part].sd && sizes[part].sd < 0.05, "{sizes:?}");
    }
}

/// Two days and a half in rows of 20 min, by Euler's rule in steps of 10 s, whose error is below 20 mK; the plate has a
/// heater in turn on and off for 5 h, the box sees the heat of the time, W by s.
fn diagnosed_days(day: impl Fn(f64) -> f64) -> Output {
    let mut noise = StreamKey::new(9, "turns", "noise").stream(0);
    let mut table = String::from("time [s],Q [W],plate [K],box [K]\n");
    let (mut plate, mut cabinet) = (290.0, 290.0);
    for step in 0..=21_600_u32 {
        let t = 10.0 * f64::from(step);
        let power = if (step / 1800).is_multiple_of(2) { 10.0 } else { 0.0 };
        if step % 120 == 0 {
            let read = [plate, cabinet].map(|value| value + SIGMA * noise.normal());
            table.push_str(&format!("{t},{power},{:.4},{:.4}\n", read[0], read[1]));
        }
        let through = 0.2 * (plate - cabinet);
        plate += 10.0 * (power - 0.5 * (plate - 290.0) - through) / 20_000.0;
        cabinet += 10.0 * (through + day(t)) / 5000.0;
    }
    diagnosed(&table, &transient()).1
}

fn transient() -> String {
    format!(
        r#"{{"transient": {{"file": "data.csv", "hold": ["Q"], "inputs": {{"roll": {{"value": 0, "unit": "deg"}}}},
        "initial": {{"temperatures": {{"all": 290}}}}, {SENSORS}}}}}"#
    )
}

/// A law of the hours of a day needs rows within the day: four of them, by the median.
#[test]
fn rows_a_day_apart_tell_nothing_of_the_hours() {
    let is_daily = |apart_s: u32| {
        let rows = (0..40_u32).map(|row| format!("{},{},290,290\n", row * apart_s, row % 2));
        let table: String = std::iter::once("time [s],Q [W],plate [K],box [K]\n".to_owned()).chain(rows).collect();
        let candidates = studied(&table, &transient()).candidates;
        assert!(candidates.iter().any(|candidate| candidate.effect == "dated-load"), "{apart_s}");
        candidates.iter().any(|candidate| candidate.effect.starts_with("daily-"))
    };
    assert!(is_daily(21_600) && !is_daily(21_601) && !is_daily(86_400));
}

#[test]
#[ignore = "thorough"]
fn heat_by_the_time_of_day_is_found_in_a_transient() {
    let output = diagnosed_days(|t| 0.8 * sin(2.0 * std::f64::consts::PI * t / 86_400.0));
    assert_eq!(output.selected, ["daily-load:box"], "{:?}", output.words);
    let sizes = &output.effects[0].amplitudes;
    for (part, truth) in [("cosine", 0.0), ("sine", 0.8)] {
        assert!((sizes[part].value - truth).abs() < 4.0 * sizes[part].sd && sizes[part].sd < 0.05, "{sizes:?}");
    }
}

/// Sun for four hours of the day: in truth half a sine, so that the law's shape is nearly, not wholly, that of the truth.
#[test]
#[ignore = "thorough"]
fn heat_for_some_hours_of_every_day_is_found_in_a_transient() {
    let output = diagnosed_days(|t| {
        let since = (t - 8.0 * 3600.0).rem_euclid(86_400.0);
        if since < 4.0 * 3600.0 { 2.5 * sin(std::f64::consts::PI * since / (4.0 * 3600.0)) } else { 0.0 }
    });
    assert_eq!(output.selected, ["daily-hours-load:box"], "{:?}", output.words);
    let own = &output.effects[0].amplitudes;
    for (part, truth, within) in [("power", 2.5, 0.25), ("peak", 10.0, 0.2), ("duration", 4.0, 0.5)] {
        assert!((own[part].value - truth).abs() < within, "{own:?}");
    }
}
