//! Tests of `diagnosis/src/twin/answer.rs`.

use bmv::diagnosis::Verdict;
use bmv::diagnosis::output::EffectResult;
use bmv::twin::answer::*;

#[test]
fn intervals_are_in_si_units_and_of_free_amplitudes_only() {
    let amount = |at_bound| serde_json::json!({"value": 50.0, "sd": 2.0, "most_probable": 49.0, "unit": "mW/K", "at_bound": at_bound});
    let effect = serde_json::json!({"id": "a:x", "effect": "a", "title": "", "where": ["x"], "where_kind": "node",
        "input": null, "probability": 0.6, "log_bayes_factor": 1.0, "group": 1,
        "amplitudes": {"conductance": amount(false), "other": amount(true)},
        "rmse_k": {"train": [null, null], "held_out": [null, null]}, "confused_with": [], "separate": ""});
    let effect: EffectResult = serde_json::from_value(effect).expect("an effect");
    let [interval] = &intervals(&effect).collect::<Vec<_>>()[..] else { panic!("one is free") };
    assert!((interval.lower - 0.04608).abs() < 1e-5 && (interval.upper - 0.05392).abs() < 1e-5, "{interval:?}");
}

#[test]
fn probabilities_are_those_of_sets() {
    let answer = Answer {
        first_step: Vec::new(),
        verdict: Verdict::Ambiguous,
        selected: vec!["a:x".to_owned()],
        groups: vec![vec!["a:x".to_owned(), "b:x".to_owned()]],
        probabilities: Vec::new(),
        models: vec![StatedModel { effects: vec!["a:x".to_owned()], probability: 0.6 }],
        nothing: 0.001,
        unexplained: 0.02,
        amplitudes: Vec::new(),
    };
    assert_eq!(answer.group_of("b:x"), ["a:x", "b:x"]);
    assert_eq!(answer.probability_of(&["a:x"]), 0.6);
    assert_eq!((answer.probability_of(&[]), answer.probability_of(&["b:x"])), (0.001, 0.0));
}
