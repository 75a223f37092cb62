//! Tests of `src/runner/difference.rs`.

use bmv::runner::difference::*;
use serde_json::json;

#[test]
fn every_kind_of_difference_is_placed() {
    let before = json!({"a": 1, "b": [1, 2, 3], "c": {"d": "x"}, "e": 2.0, "f": null});
    let after = json!({"a": 1.5, "b": [1, 4], "c": {"d": "x", "g": true}, "e": 2, "f": null});
    let lines: Vec<_> = differences(&before, &after).iter().map(ToString::to_string).collect();
    assert_eq!(
        lines,
        ["a: 1 -> 1.5 (+5.000e-1 of it)", "b[1]: 2 -> 4 (+1.000e0 of it)", "b[2]: gone, was 3", "c.g: new, true"]
    );
    assert_eq!(differences(&before, &before), []);
}

#[test]
fn a_whole_that_differs_and_long_values_read_well() {
    let differences = differences(&json!("x".repeat(100)), &json!([]));
    assert_eq!(differences[0].to_string(), format!("everything: \"{}... -> []", "x".repeat(56)));
}

#[test]
fn large_integers_are_not_compared_as_floats() {
    assert_eq!(differences(&json!(9007199254740993_u64), &json!(9007199254740992_u64)).len(), 1);
}
