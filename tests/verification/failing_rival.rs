//! What the fitted rows want most and the held-out rows contradict is no rival of an effect that explains both.

use bmv::diagnosis::{Output, Verdict};
use bmv::math::functions::sin;
use bmv::random::StreamKey;

use super::small_study;

/// Water that is heated as it flows through; its inlet is not logged.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A water heater with through flow",
  "inputs": {"duty": {"unit": "1", "nominal": 0.2, "range": [0, 1]}},
  "parameters": {
    "P": {"unit": "W", "nominal": 2200, "prior": {"uniform": [500, 6000]}, "source": "assumed"},
    "C": {"unit": "J/K", "nominal": 3000, "prior": {"uniform": [100, 20000]}, "source": "assumed"},
    "T_in": {"unit": "degC", "nominal": 20, "prior": {"normal": {"mean": 20, "sd": 4, "lower": 8, "upper": 29}}, "source": "assumed"}},
  "nodes": {"inlet": {"boundary": "T_in"}, "water": {"capacity": "C"}},
  "flows": {"stream": {"between": ["inlet", "water"], "heat": "45 * (Ta - Tb)", "one_way": true}},
  "loads": {"heater": {"into": "water", "power": "P * duty"}}
}"#;
const NOISE_K: f64 = 0.02;
/// How far the model is wrong everywhere, K.
const MODEL_ERROR_K: f64 = 0.04;

/// A step of the heater up, which is fitted, and down, which is held out; the thermometer hangs in a pipe that the water reaches after 90 s.
/// Diagnosed without an effect.
fn delayed(without: &str) -> Output {
    const HALVES: usize = 3048;
    const DELAY: usize = 180;
    let mut stream = StreamKey::new(31, "delayed water", "noise").stream(0);
    let duty = |half: usize| if (472..2088).contains(&half) { 0.4 } else { 0.2 };
    // By hand, in steps of half a second of a time constant of 90 s.
    let mut water = vec![29.25_f64];
    for half in 0..HALVES {
        let now = water[half];
        water.push(now + 0.5 * (2196.0 * duty(half) - 45.05 * (now - 19.5)) / 4000.0);
    }
    let mut table = String::from("time [s],duty [1],T_out [degC]\n");
    for half in (0..=HALVES).step_by(16) {
        let second = 0.5 * half as f64;
        let read = water[half.saturating_sub(DELAY)] + NOISE_K * stream.normal() + MODEL_ERROR_K * sin(second / 70.0);
        table.push_str(&format!("{second},{},{read:.3}\n", duty(half)));
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "Two steps", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"steps": {"transient": {"file": "data.csv", "hold": ["duty"], "initial": {"temperatures": {"water": {"value": 29.26, "unit": "degC"}}},
            "sensors": {"T_out": {"measures": "water", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 4}}, "unit": "K"}}},
            "held_out": {"intervals": [{"from": {"value": 1050, "unit": "s"}}]}}}},
        "jobs": {"missing": {"diagnose": {"without": [WITHOUT]}}}}"#;
    let pass = pass.replace("WITHOUT", without);
    let folder = tempfile::tempdir().unwrap();
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

#[test]
#[ignore = "thorough"]
fn water_that_reaches_a_thermometer_late_is_an_offset_in_time() {
    let output = delayed("");
    assert_eq!(output.selected, ["sensor-clock:T_out"], "{:?}", output.words);
    let effect = output.effects.iter().find(|effect| effect.id == "sensor-clock:T_out").unwrap();
    // Rows are 8 s apart, and the model error lasts over nine of them.
    let behind = &effect.amplitudes["behind"];
    assert!((behind.value + 90.0).abs() < 8.0, "{behind:?}");
    assert!(effect.probability > 0.9, "{}", effect.probability);
}

#[test]
#[ignore = "thorough"]
fn the_lag_of_a_thermometer_is_a_step_though_the_fitted_rows_want_more_what_fails_on_the_others() {
    let output = delayed(r#""sensor-clock""#);
    assert_eq!(
        (output.verdict, output.selected.as_slice()),
        (Verdict::Ambiguous, &["sensor-lag:T_out".to_owned()][..])
    );
    let of = |id: &str| output.models.iter().find(|model| model.effects == [id]).unwrap_or_else(|| panic!("{id}"));
    let [before, after] = [None, Some("sensor-lag:T_out")].map(|id| {
        let own = output.models.iter().find(|model| model.effects.iter().map(String::as_str).eq(id));
        own.and_then(|own| own.rmse_k.held_out).unwrap()
    });
    assert!(after * after < 0.5 * before * before, "{before} K, {after} K");
    // The premise: the fitted rows want another more by far, and the held-out ones contradict it.
    let wanted = output.models.iter().filter(|model| model.effects.len() == 1);
    let wanted = wanted.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)).unwrap();
    assert!(wanted.log_evidence > of("sensor-lag:T_out").log_evidence + 10.0, "{wanted:?}");
    assert!(wanted.rmse_k.held_out.unwrap() > before, "{wanted:?}");
    let fails = format!("{}, fails on the held-out rows", wanted.effects[0]);
    assert!(output.words.iter().any(|said| said.contains(&fails)), "{:?}", output.words);
    // What is a delay in truth is no lag: the program is not sure of it.
    let lag = output.effects.iter().find(|effect| effect.id == "sensor-lag:T_out").unwrap();
    assert!(lag.probability <= 0.5, "{}", lag.probability);
    assert!(
        output.words.iter().any(|said| said.contains("something that neither of them describes")),
        "{:?}",
        output.words
    );
    let rival = output.effects.iter().find(|effect| effect.id == wanted.effects[0]);
    assert!(rival.is_none_or(|rival| rival.group.is_none()), "{rival:?}");
}
