//! Tests of `diagnosis/src/diagnosis/verdict/storage_alternative.rs`.

use bmv::diagnosis::verdict::storage_alternative::explains_as_much;

#[test]
fn a_storage_effect_explains_as_much_within_a_twentieth() {
    assert!(explains_as_much([100.0, 20.0, 20.0]));
    assert!(explains_as_much([100.0, 20.0, 5.0]), "more");
    assert!(explains_as_much([100.0, 20.0, 24.0]));
    assert!(!explains_as_much([100.0, 20.0, 25.0]));
    assert!(!explains_as_much([100.0, 100.0, 99.0]), "surroundings that explain nothing");
    assert!(!explains_as_much([100.0, f64::NAN, 20.0]));
}
