//! Tests of `diagnosis/src/diagnosis/verdict/experiment_words.rs`.

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
    assert_eq!(said(&["a:1", "b:1"]), "a:1 and b:1");
    assert_eq!(said(&["a:1 + c:1", "b:1 + c:1", "c:1 + d:1 + e:1"]), "a:1, b:1 and d:1 + e:1 (each beside c:1)");
    assert_eq!(said(&["a:1", "a:1 + b:1"]), "a:1 and a:1 + b:1", "what one has alone is not left out of it");
    assert_eq!(said(&["a:1 + b:1", "b:1 + c:1", "c:1 + a:1"]), "a:1 + b:1, b:1 + c:1 and c:1 + a:1");
    assert_eq!(
        said(&["a:plate + foot + c:1", "b:plate + foot + c:1"]),
        "a:plate + foot and b:plate + foot (each beside c:1)",
        "a name may hold a plus"
    );
    assert_eq!(repeated(0.5), None, "no better than guessing");
    assert_eq!(repeated(0.6), Some(0.6));
}
