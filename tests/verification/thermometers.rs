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

/// What is wrong with the thermometers.
#[derive(Clone, Copy, Default)]
struct Faults {
    /// Time constant of both, s.
    lag_s: f64,
    /// By how much each clock is behind, s.
    behind_s: [f64; 2],
}

/// Steps of a simulation in a second.
const STEPS: usize = 10;

/// A heater that goes on and off, both thermometers following by first order with the same time constant, by Euler's rule,
/// whose error is below 5 mK, each with its own clock.
fn diagnosed(faults: Faults) -> Output {
    let mut noise = StreamKey::new(5, "thermometers", "noise").stream(0);
    let power_w = |second: usize| if (second / 300).is_multiple_of(2) { 20.0 } else { 2.0 };
    let (mut state, mut read) = ([290.0_f64; 2], [290.0_f64; 2]);
    let mut course = vec![read];
    let step_s = 1.0 / STEPS as f64;
    for step in 0..3000 * STEPS {
        let [plate, cabinet] = state;
        let through = 0.5 * (plate - cabinet);
        state[0] += step_s * (power_w(step / STEPS) - 0.5 * (plate - 290.0) - through) / 100.0;
        state[1] += step_s * through / 50.0;
        for (read, kelvin) in read.iter_mut().zip(state) {
            *read += step_s * (kelvin - *read) / faults.lag_s.max(step_s);
        }
        course.push(read);
    }
    let mut table = String::from("time [s],Q [W],plate [K],box [K]\n");
    for second in (0..2400).step_by(20) {
        let shown = [0, 1].map(|sensor| {
            let at = (second as f64 + faults.behind_s[sensor]).max(0.0) * STEPS as f64;
            course[at as usize][sensor] + SIGMA_K * noise.normal()
        });
        table.push_str(&format!("{second},{},{:.4},{:.4}\n", power_w(second), shown[0], shown[1]));
    }
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", PASS)]);
    let key = StreamKey::new(7, "thermometers", "diagnosis");
    Diagnosis::new(problem, Settings::default(), key).run().expect("a diagnosis")
}

/// The time that was selected as the one effect, s, and its standard deviation.
fn selected_time(output: &Output, id: &str, parameter: &str) -> (f64, f64) {
    assert_eq!(output.selected, [id], "{:?}", output.words);
    let effect = output.effects.iter().find(|effect| effect.id == id).expect("listed");
    let time = &effect.amplitudes[parameter];
    (time.value, time.sd)
}

#[test]
#[ignore = "thorough"]
fn a_lag_of_all_thermometers_is_one_effect() {
    let output = diagnosed(Faults { lag_s: 25.0, ..Faults::default() });
    let (constant, sd) = selected_time(&output, "sensor-lag:all thermometers", "time_constant");
    assert!((constant - 25.0).abs() < 4.0 * sd && sd < 1.0, "{constant} {sd}");
    // One size explains both: a lag of one thermometer does not.
    for other in output.effects.iter().filter(|other| other.id != output.selected[0]) {
        // Heat that arrives late looks like it where the readings show little but the heater's steps.
        let most = if other.effect == "heater-capacity" { 0.1 } else { 0.05 };
        assert!(other.probability < most, "{} {}: {:?}", other.id, other.probability, output.words);
    }
}

#[test]
fn thermometers_that_follow_at_once_have_no_lag() {
    let output = diagnosed(Faults::default());
    assert_eq!(output.selected, Vec::<String>::new(), "{:?}", output.words);
}

/// A minute late is no lag: what follows a step begins late.
#[test]
#[ignore = "thorough"]
fn a_clock_that_is_ahead_is_told_from_a_lag() {
    let output = diagnosed(Faults { behind_s: [0.0, -60.0], ..Faults::default() });
    let (behind, sd) = selected_time(&output, "sensor-clock:box", "behind");
    assert!((behind + 60.0).abs() < 4.0 * sd && sd < 1.0, "{behind} {sd}");
    let lag = output.effects.iter().find(|effect| effect.id == "sensor-lag:box").expect("listed");
    assert!(lag.probability < 0.01, "{}", lag.probability);
}

#[test]
#[ignore = "thorough"]
fn clocks_that_are_behind_are_those_of_all_thermometers() {
    let output = diagnosed(Faults { behind_s: [40.0; 2], ..Faults::default() });
    let (behind, sd) = selected_time(&output, "sensor-clock:all thermometers", "behind");
    assert!((behind - 40.0).abs() < 4.0 * sd && sd < 2.0, "{behind} {sd}");
}

/// Farther apart than first order in the time would show: the heater's next step lies in between.
#[test]
#[ignore = "thorough"]
fn a_clock_that_is_ahead_by_minutes_is_found() {
    let output = diagnosed(Faults { behind_s: [0.0, -400.0], ..Faults::default() });
    let (behind, sd) = selected_time(&output, "sensor-clock:box", "behind");
    assert!((behind + 400.0).abs() < 4.0 * sd && sd < 1.0, "{behind} {sd}");
}
