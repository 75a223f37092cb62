//! Tests of `core/src/diagnosis/verdict/store_in_place.rs`.

use bmv::diagnosis::verdict::store_in_place::explains_as_much;

#[test]
fn a_store_explains_as_much_within_a_twentieth() {
    assert!(explains_as_much([100.0, 20.0, 20.0]));
    assert!(explains_as_much([100.0, 20.0, 5.0]), "more");
    assert!(explains_as_much([100.0, 20.0, 24.0]));
    assert!(!explains_as_much([100.0, 20.0, 25.0]));
    assert!(!explains_as_much([100.0, 100.0, 99.0]), "surroundings that explain nothing");
    assert!(!explains_as_much([100.0, f64::NAN, 20.0]));
}
