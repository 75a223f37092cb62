//! What changes at a date: a joint between two steady phases, a sensor likewise, and heat in a transient; and a joint at the same
//! time into several runs. All by hand.

use bmv::diagnosis::{Diagnosis, Output, Problem, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box on a plate on a sink",
  "inputs": {"Q": {"unit": "W", "nominal": 0, "range": [0, 30]}, "P": {"unit": "W", "nominal": 0, "range": [0, 10]}},
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.1}}, "source": "assumed"},
    "H": {"unit": "W/K", "nominal": 0.2, "prior": {"normal": {"mean": 0.2, "sd": 0.05}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "290"}, "plate": {"capacity": 200}, "box": {"capacity": 100}},
  "conductors": {"feet": {"between": ["plate", "sink"], "conductance": "G"}, "strap": {"between": ["box", "plate"], "conductance": "H"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}, "board": {"into": "box", "power": "P"}}
}"#;

const SIGMA: f64 = 0.2;

fn diagnosed(table: &str, measurement: &str) -> (Problem, Output) {
    diagnosed_runs(&[("data.csv".to_owned(), table.to_owned())], &format!(r#""test": {measurement}"#), "")
}

/// Of a pass with these measurements and these entries under `adopt`.
fn diagnosed_runs(tables: &[(String, String)], measurements: &str, adopt: &str) -> (Problem, Output) {
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Dates", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{{measurements}}}, "adopt": {{{adopt}}}, "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#
    );
    let tables = tables.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    let files = [("model.json", MODEL), ("pass-1.json", pass.as_str())].into_iter().chain(tables);
    let problem = small_study::problem(&files.collect::<Vec<_>>());
    let key = StreamKey::new(7, "dates", "diagnosis");
    let output = Diagnosis::new(problem.clone(), Settings::default(), key).run().expect("a diagnosis");
    (problem, output)
}

const SENSORS: &str = r#""sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.2, "unit": "K"}},
    "box": {"measures": "box", "sigma": {"value": 0.2, "unit": "K"}}}"#;

/// Sixteen phases; from the tenth on the strap conducts `strap` W/K and the box' sensor reads `bias` too high.
fn steady(strap: f64, bias: f64) -> Output {
    let mut noise = StreamKey::new(8, "dates", "noise").stream(0);
    let mut table = String::from("phase,Q [W],P [W],plate [K],box [K]\n");
    for row in 1..=16_u32 {
        let (q, p) = (3.0 + f64::from(row * 7 % 16), 1.0 + 0.5 * f64::from(row * 5 % 16));
        let (h, b) = if row >= 10 { (strap, bias) } else { (0.2, 0.0) };
        let plate = 290.0 + (q + p) / 0.5;
        let cabinet = plate + p / h;
        let read = [plate, cabinet + b].map(|value| value + SIGMA * noise.normal());
        table.push_str(&format!("P{row:02},{q},{p},{:.4},{:.4}\n", read[0], read[1]));
    }
    diagnosed(&table, &format!(r#"{{"steady": {{"file": "data.csv", {SENSORS}}}}}"#)).1
}

#[test]
#[ignore = "thorough"]
fn a_joint_that_opens_for_good_is_dated_between_two_phases() {
    let output = steady(0.14, 0.0);
    assert_eq!(output.selected, ["dated-conductance:strap"], "{:?}", output.words);
    let own = &output.effects[0].amplitudes;
    assert!(9.0 < own["date"].most_probable && own["date"].most_probable < 10.0, "{own:?}");
    // The truth is -0.3; four standard deviations.
    assert!((own["change"].value + 0.3).abs() < 4.0 * own["change"].sd && own["change"].sd < 0.02, "{own:?}");
    assert!(output.words.iter().any(|said| said.contains("between the phases P09 and P10")), "{:?}", output.words);
}

#[test]
fn a_sensor_that_jumps_and_stays_is_dated() {
    let output = steady(0.2, 1.5);
    assert_eq!(output.selected, ["dated-bias:box"], "{:?}", output.words);
    let own = &output.effects[0].amplitudes;
    assert!(9.0 < own["date"].most_probable && own["date"].most_probable < 10.0, "{own:?}");
    assert!((own["bias"].value - 1.5).abs() < 4.0 * own["bias"].sd, "{own:?}");
}

/// 10 W in turn on and off for 1500 s; from a date on `watts` more, and a sensor of the box that reads `bias` too high. In steps of
/// half a second by Euler's rule, whose error is below 10 mK.
fn transient(date_s: f64, watts: f64, bias: f64) -> (Problem, Output) {
    let mut noise = StreamKey::new(9, "dates", "noise").stream(0);
    let mut table = String::from("time [s],Q [W],plate [K],box [K]\n");
    let power = |t: f64| if ((t / 1500.0) as u64).is_multiple_of(2) { 10.0 } else { 0.0 };
    let (mut plate, mut cabinet) = (290.0, 290.0);
    for half in 0..=16_000 {
        let t = 0.5 * f64::from(half);
        if half % 100 == 0 {
            let off = if t >= date_s { bias } else { 0.0 };
            let read = [plate, cabinet + off].map(|value| value + SIGMA * noise.normal());
            table.push_str(&format!("{t},{},{:.4},{:.4}\n", power(t), read[0], read[1]));
        }
        let more = if t >= date_s { watts } else { 0.0 };
        let through = 0.2 * (plate - cabinet);
        plate += 0.5 * (power(t) + more - 0.5 * (plate - 290.0) - through) / 200.0;
        cabinet += 0.5 * through / 100.0;
    }
    let measurement = format!(
        r#"{{"transient": {{"file": "data.csv", "hold": ["Q"], "time_zero": "2026-03-14T06:00:00", "inputs": {{"P": {{"value": 0, "unit": "W"}}}},
        "initial": {{"temperatures": {{"all": 290}}}}, {SENSORS}}}}}"#
    );
    diagnosed(&table, &measurement)
}

#[test]
#[ignore = "thorough"]
fn heat_that_sets_in_during_a_transient_is_dated_within_three_rows() {
    const DATE_S: f64 = 4210.0;
    let (problem, output) = transient(DATE_S, 2.0, 0.0);
    assert!(problem.candidates.iter().any(|own| own.id == "dated-conductance:feet"), "what competes with it");
    assert_eq!(output.selected, ["dated-load:plate"], "{:?}", output.words);
    let own = &output.effects[0].amplitudes;
    assert!((own["date"].value - DATE_S).abs() < 150.0, "{own:?}");
    // 1 h 10 min after the record's start.
    let since = output.effects[0].since.as_deref().expect("the record says when its time is 0");
    assert!(since.starts_with("2026-03-14 07:") && since < "2026-03-14 07:13", "{since}");
    assert!(output.words.iter().any(|said| said.contains(&format!(" min ({since}) on"))), "{:?}", output.words);
    // Four standard deviations.
    assert!((own["power"].value - 2.0).abs() < 4.0 * own["power"].sd && own["power"].sd < 0.1, "{own:?}");
}

/// As much as the noise's standard deviation. Heat of the box' own from then on looks much like it.
#[test]
#[ignore = "thorough"]
fn a_small_jump_of_a_sensor_in_a_transient_is_dated_wherever_it_is() {
    for date_s in [2420.0, 4820.0, 5630.0] {
        let (_, output) = transient(date_s, 0.0, 0.2);
        let effect = output.effects.iter().find(|own| own.id == "dated-bias:box").expect("listed");
        assert!(effect.group == Some(1) || output.selected == ["dated-bias:box"], "{date_s}: {:?}", output.words);
        let own = &effect.amplitudes;
        assert!((own["date"].value - date_s).abs() < 400.0, "{date_s}: {own:?}");
        assert!((own["bias"].value - 0.2).abs() < 4.0 * own["bias"].sd, "{date_s}: {own:?}");
    }
}

/// Runs of 2400 s at these powers, each logged from its own second on; 575 s into each the feet conduct `feet` times as well. In steps
/// of half a second by Euler's rule.
fn runs(powers: &[f64], feet: f64, adopt: &str) -> (Problem, Output) {
    const EVENT_S: f64 = 575.0;
    let mut noise = StreamKey::new(10, "dates", "noise").stream(0);
    let (mut tables, mut measurements) = (Vec::new(), Vec::new());
    for (run, power) in powers.iter().enumerate() {
        let begin = 100.0 * run as f64;
        let mut table = String::from("time [s],Q [W],plate [K],box [K]\n");
        let (mut plate, mut cabinet) = (290.0, 290.0);
        for half in 0..=4800 {
            let t = 0.5 * f64::from(half);
            if half % 60 == 0 {
                let read = [plate, cabinet].map(|value| value + SIGMA * noise.normal());
                table.push_str(&format!("{},{power},{:.4},{:.4}\n", begin + t, read[0], read[1]));
            }
            let loss = if t >= EVENT_S { 0.5 * feet } else { 0.5 };
            let through = 0.2 * (plate - cabinet);
            plate += 0.5 * (power - loss * (plate - 290.0) - through) / 200.0;
            cabinet += 0.5 * through / 100.0;
        }
        let file = format!("run-{run}.csv");
        measurements.push(format!(
            r#""run {run}": {{"transient": {{"file": "{file}", "hold": ["Q"], "inputs": {{"P": {{"value": 0, "unit": "W"}}}},
            "initial": {{"temperatures": {{"all": 290}}}}, {SENSORS}}}}}"#
        ));
        tables.push((file, table));
    }
    diagnosed_runs(&tables, &measurements.join(", "), adopt)
}

fn has_event(problem: &Problem) -> bool {
    problem.candidates.iter().any(|own| own.effect.starts_with("event-"))
}

#[test]
#[ignore = "thorough"]
fn a_joint_that_changes_at_the_same_time_into_every_run_has_that_time() {
    let (problem, output) = runs(&[8.0, 14.0, 20.0], 1.5, "");
    assert!(problem.candidates.iter().any(|own| own.id == "event-load:plate"), "what competes with it");
    assert_eq!(output.selected, ["event-conductance:feet"], "{:?}", output.words);
    let own = &output.effects[0].amplitudes;
    assert!((own["elapsed"].value - 575.0).abs() < 30.0, "{own:?}");
    // Four standard deviations.
    assert!((own["change"].value - 0.5).abs() < 4.0 * own["change"].sd && own["change"].sd < 0.03, "{own:?}");
    assert!(output.words.iter().any(|said| said.contains("after each start on")), "{:?}", output.words);
}

#[test]
#[ignore = "thorough"]
fn runs_with_nothing_missing_lack_no_event_and_a_single_run_has_no_candidate_of_it() {
    let (problem, output) = runs(&[8.0, 14.0], 1.0, "");
    assert!(has_event(&problem));
    assert!(output.selected.is_empty(), "{:?}", output.words);
    assert!(!has_event(&runs(&[14.0], 1.0, "").0));
}

/// What is adopted acts in a single run too.
#[test]
#[ignore = "thorough"]
fn nothing_is_missing_beside_an_adopted_event() {
    let adopt = r#""venting": {"effect": {"event-conductance": {"where": "feet"}}, "because": "air is let in"}"#;
    for powers in [&[8.0, 14.0][..], &[14.0]] {
        let (problem, output) = runs(powers, 1.5, adopt);
        assert!(problem.model.parameters.iter().any(|own| own.name == "venting.elapsed"));
        assert!(output.selected.is_empty(), "{:?}", output.words);
    }
}
