//! Tests of `src/cli/diagnose.rs`.

use bmv::cli::diagnose::next;
use bmv::diagnosis::Output;
use serde_json::{Value, json};

/// An ambiguous diagnosis that selected effects, each with its probability, that of errors of the model, and what it is confused with.
fn output(selected: &[(&str, f64, f64, Option<u64>)]) -> Output {
    let rmse = json!({"train": [null, null], "held_out": [null, null]});
    let effect = |(id, probability, model_error, group): &(&str, f64, f64, Option<u64>)| {
        json!({"id": id, "effect": "a", "title": "A", "where": ["x"], "where_kind": "node", "input": null, "probability": probability,
            "model_error": model_error, "log_bayes_factor": 9.0, "log_bayes_factor_scales": null, "group": group, "amplitudes": {},
            "rmse_k": rmse, "watts": null, "confused_with": [], "separate": ""})
    };
    let mut effects: Vec<Value> = selected.iter().map(effect).collect();
    // A rival of each that has a group.
    effects.extend(selected.iter().filter(|own| own.3.is_some()).map(|own| effect(&("rival:x", 0.1, 0.0, own.3))));
    let ids: Vec<&str> = selected.iter().map(|own| own.0).collect();
    let errors = json!({"train": null, "held_out": null});
    let misfit = json!({"reduced_chi2": 9.0, "family_wise_p": 0.0, "rmse_k": errors, "tests": []});
    let whole = json!({"verdict": "ambiguous", "words": [], "probability_nothing": 0.0, "probability_unexplained": 0.0, "misfit": misfit,
        "effects": effects, "models": [], "selected": ids, "unseen": [], "detectable": {}, "noise": {},
        "separating_experiment": null, "heat": [], "goes_with": [], "held_out_test": null, "remaining_p": null,
        "looked_at": [0, 0, 0], "warnings": []});
    serde_json::from_value(whole).expect("a diagnosis")
}

#[test]
fn the_next_command_names_no_effect_that_errors_of_the_model_explain_as_well() {
    let of = |selected: &[(&str, f64, f64, Option<u64>)]| next(&output(selected), "bmv adopt p.json").expect("a step");
    let open = of(&[("path:a", 0.3, 0.0, Some(1)), ("daily:b", 0.5, 0.5, None), ("bias:c", 0.2, 0.5, Some(2))]);
    assert!(open.ends_with("as in bmv adopt p.json path:a"), "{open}");
    let settled = of(&[("path:a", 0.97, 0.0, None), ("bias:c", 0.2, 0.5, Some(2))]);
    assert!(settled.starts_with("next: bmv adopt p.json path:a;") && !settled.contains("bias:c"), "{settled}");
    let with = of(&[("path:a", 0.97, 0.0, None), ("load:b", 0.4, 0.0, Some(2)), ("bias:c", 0.2, 0.5, Some(3))]);
    assert!(with.ends_with("as in bmv adopt p.json path:a load:b"), "{with}");
    let weak = of(&[("daily:b", 0.5, 0.5, Some(1))]);
    assert!(weak.ends_with("as in bmv adopt p.json daily:b"), "{weak}");
}

/// A sensor that is off looks the same as a start that is: the way on is stated for that case too.
#[test]
fn a_doubtful_start_goes_first_and_is_no_dead_end() {
    let start = json!([{"code": "start-apart", "message": "the first readings lie apart", "repair": null}]);
    let doubtful = |selected: &[(&str, f64, f64, Option<u64>)]| {
        let doubts = serde_json::from_value(start.clone()).expect("doubts");
        next(&Output { doubts, ..output(selected) }, "bmv adopt p.json")
    };
    let some = doubtful(&[("path:a", 0.97, 0.0, None)]).expect("a step");
    assert_eq!(some, "next: check the start, then bmv diagnose again; if the start is right, bmv adopt p.json path:a");
    assert_eq!(doubtful(&[]).as_deref(), Some("next: check the start, then bmv diagnose again"));
}
