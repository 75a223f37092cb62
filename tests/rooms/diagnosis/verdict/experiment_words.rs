//! Tests of `core/src/diagnosis/verdict/experiment_words.rs`.

use bmv::diagnosis::verdict::experiment_words::*;
use bmv::measurement::Rows;

use super::words::star;

#[test]
fn a_phase_beyond_what_was_set_is_said_with_what_keeps_it_out() {
    let problem = star();
    let input = &problem.model.inputs[0];
    let values: Vec<f64> = match &problem.measurements[0].rows {
        Rows::Steady(phases) => phases.iter().map(|phase| phase.inputs[0]).collect(),
        Rows::Transient { .. } => panic!("steady"),
    };
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let said = |value: f64| {
        let conditions = serde_json::json!({&input.name: {"value": value, "unit": ""}});
        let experiment =
            serde_json::from_value(serde_json::json!({"between": [], "conditions": conditions, "probability": 0.9,
            "repeat_probability": 0.5, "limits_ok": true, "predictions": {}}));
        beyond_what_was_set(&experiment.expect("an experiment"), &problem)
    };
    assert_eq!(said(values[0]), None);
    let beyond = said(highest + 500.0).expect("outside");
    assert!(beyond.contains(&format!("`{}` at ", input.name)) && beyond.contains("so far"), "{beyond}");
    assert!(beyond.contains("a narrower `range` of that input"), "{beyond}");
}

#[test]
fn what_all_sets_have_is_named_once() {
    let said = |sets: &[&str]| sets_apart(&sets.iter().map(|set| (*set).to_owned()).collect::<Vec<_>>());
    assert_eq!(said(&["a", "b"]), "a and b");
    assert_eq!(said(&["a + c", "b + c", "c + d + e"]), "a, b and d + e (each beside c)");
    assert_eq!(said(&["a", "a + b"]), "a and a + b", "what one has alone is not left out of it");
    assert_eq!(said(&["a + b", "b + c", "c + a"]), "a + b, b + c and c + a");
    assert_eq!(repeated(0.5), None, "no better than guessing");
    assert_eq!(repeated(0.6), Some(0.6));
}
