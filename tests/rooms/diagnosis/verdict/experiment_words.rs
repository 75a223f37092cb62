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
