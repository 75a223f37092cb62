//! A model that is a little wrong everywhere: the error that no effect explains is named, and the effect is still found.

use bmv::diagnosis::{Diagnosis, Output, Settings, Verdict};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "Three plates in a row over a sink",
  "inputs": {
    "Q_a": {"unit": "W", "nominal": 0, "range": [0, 12]},
    "Q_c": {"unit": "W", "nominal": 0, "range": [0, 12]},
    "T_s": {"unit": "K", "nominal": 280, "range": [250, 300]}
  },
  "parameters": {
    "G_s": {"unit": "W/K", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.1}}, "source": "assumed"},
    "G_ab": {"unit": "W/K", "nominal": 0.3, "prior": {"normal": {"mean": 0.3, "sd": 0.06}}, "source": "assumed"},
    "G_bc": {"unit": "W/K", "nominal": 0.3, "prior": {"normal": {"mean": 0.3, "sd": 0.06}}, "source": "assumed"}
  },
  "nodes": {"sink": {"boundary": "T_s"}, "a": {"capacity": 200}, "b": {"capacity": 200}, "c": {"capacity": 200}},
  "conductors": {
    "foot": {"between": ["a", "sink"], "conductance": "G_s"},
    "a-b": {"between": ["a", "b"], "conductance": "G_ab"},
    "b-c": {"between": ["b", "c"], "conductance": "G_bc"}
  },
  "loads": {"heater a": {"into": "a", "power": "Q_a"}, "heater c": {"into": "c", "power": "Q_c"}}
}"#;

const PASS: &str = r#"{"format": "bmv-pass/1", "title": "Phases", "parent": null, "model": "model.json", "seed": 3,
    "measurements": {"test": {"steady": {"file": "data.csv", "sensors": {
      "a": {"measures": "a", "sigma": {"value": 0.1, "unit": "K"}},
      "b": {"measures": "b", "sigma": {"value": 0.1, "unit": "K"}},
      "c": {"measures": "c", "sigma": {"value": 0.1, "unit": "K"}}}}}},
    "jobs": {"missing": {"diagnose": {}}}}"#;

/// Standard deviation of what the model owes each reading, K: six times the noise that is stated.
const MODEL_ERROR_K: f64 = 0.6;

/// Temperatures of the plates, K, by elimination: the parameters as believed, and a path from c to the sink.
fn plates(q: [f64; 2], sink: f64, path: f64) -> [f64; 3] {
    // Above the sink: b = (a + c) / 2; 0.5 a + 0.3 (a - b) = q_a; path c + 0.3 (c - b) = q_c.
    let (diagonal_a, diagonal_c, beside) = (0.5 + 0.15, path + 0.15, -0.15);
    let determinant = diagonal_a * diagonal_c - beside * beside;
    let a = (q[0] * diagonal_c - beside * q[1]) / determinant;
    let c = (diagonal_a * q[1] - beside * q[0]) / determinant;
    [sink + a, sink + 0.5 * (a + c), sink + c]
}

/// What is simulated: a path from c to the sink, W/K; what the model owes each reading, K; a fault: phase, plate, K.
fn diagnosed(path: f64, error_k: f64, fault: Option<(usize, usize, f64)>) -> Output {
    let mut draws = StreamKey::new(11, "model error", "plates").stream(0);
    let mut table = String::from("phase,Q_a [W],Q_c [W],T_s [K],a [K],b [K],c [K]\n");
    for phase in 0..16 {
        let at = |step: usize| 4.0 * (phase * step % 4) as f64;
        let (q, sink) = ([at(1), at(3) + f64::from(phase as u32 / 4)], 255.0 + 3.0 * ((phase * 7) % 16) as f64);
        let mut read = plates(q, sink, path).map(|kelvin| kelvin + error_k * draws.normal());
        if let Some((_, plate, off)) = fault.filter(|fault| fault.0 == phase) {
            read[plate] += off;
        }
        table.push_str(&format!("P{phase:02},{},{},{sink},{:.4},{:.4},{:.4}\n", q[0], q[1], read[0], read[1], read[2]));
    }
    let problem = small_study::problem(&[("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", PASS)]);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(3, "model error", "test")).run().unwrap()
}

#[test]
#[ignore = "thorough"]
fn an_effect_is_found_beside_a_model_error_whose_size_is_named() {
    let output = diagnosed(0.1, MODEL_ERROR_K, None);
    assert!(matches!(output.verdict, Verdict::Identified | Verdict::Ambiguous), "{:?}", output.words);
    let first = &output.steps[0];
    let own =
        |id: &String| id.starts_with("conductive-path:") && id.contains(":c") || id.starts_with("path-to-ambient:c");
    assert!(first.effect.iter().chain(&first.alternatives).any(own), "{first:?}");
    let [before, after] = first.rmse_k.train.map(Option::unwrap);
    assert!(after < 0.6 * before, "{before} K to {after} K");
    for noise in output.noise.values() {
        // Of 48 readings less some 6 parameters: 0.6 K within 3 sd of 0.6 / sqrt(84), and what the effect takes up.
        let error = noise.model_error.unwrap();
        assert!((0.4..0.8).contains(&error) && noise.sigma == 0.1 && noise.counts_as > Some(error), "{noise:?}");
    }
    let wrong = output.effects.iter().filter(|effect| effect.probability > 0.9 && !own(&effect.id));
    assert_eq!(wrong.map(|effect| &effect.id).collect::<Vec<_>>(), Vec::<&String>::new());
}

#[test]
#[ignore = "thorough"]
fn where_no_effect_explains_a_misfit_the_model_error_is_called_unexplained() {
    let output = diagnosed(0.0, MODEL_ERROR_K, None);
    assert_eq!((output.verdict, output.selected.len()), (Verdict::Unexplained, 0), "{:?}", output.words);
    assert!(output.misfit.family_wise_p < 1e-6, "the stated noise is far too small");
    assert!(!output.only_small_errors, "the tests find something definite");
    assert!(output.words.iter().any(|words| words.contains("a little wrong everywhere")), "{:?}", output.words);
    assert!(output.effects.iter().all(|effect| effect.probability < 0.9));
}

/// A reading of 4 K beside all others, with noise as it is stated.
#[test]
#[ignore = "thorough"]
fn a_reading_that_stands_out_is_left_out_and_the_effect_is_identified() {
    let output = diagnosed(0.1, 0.1, Some((5, 1, 4.0)));
    let faults = |output: &Output| -> Vec<String> {
        output.doubts.iter().filter(|doubt| doubt.code == "outlying").map(|doubt| doubt.message.clone()).collect()
    };
    let [fault] = faults(&output).try_into().unwrap();
    assert!(fault.starts_with("1 reading of b in test (P05) stands out"), "{fault}");
    assert_eq!(output.verdict, Verdict::Identified, "{:?}", output.words);
    let effect = &output.effects[0];
    // The amplitude within 3 of its standard deviations.
    let size = &effect.amplitudes["conductance"];
    assert!((size.value - 0.1).abs() < 3.0 * size.sd, "{size:?}");
    let clean = diagnosed(0.1, 0.1, None);
    assert_eq!(faults(&clean), Vec::<String>::new());
    assert_eq!(clean.selected, output.selected);
}
