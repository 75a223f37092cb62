//! Tests of `core/src/diagnosis/verdict/small_effects.rs`.

use bmv::diagnosis::verdict::small_effects::Left;

#[test]
fn an_effect_may_be_model_error_beside_a_stronger_one_or_beside_what_is_left() {
    let left = |strongest, squares, is_found| Left { strongest, squares, is_allowed_for: false, is_found };
    assert_eq!(left(100.0, 10.0, false).is_model_error(100.0), 0.0);
    // Two effects of one size.
    assert_eq!(left(60.0, 0.0, false).is_model_error(40.0), 0.0);
    // But where something is left, the lesser one may be model error; the strongest is not.
    assert_eq!(left(60.0, 0.0, true).is_model_error(40.0), 0.5);
    assert_eq!(left(60.0, 0.0, true).is_model_error(60.0), 0.0);
    // A third of the strongest in readings is a ninth in squares.
    assert_eq!(left(100.0, 0.0, false).is_model_error(11.0), 0.5);
    // It takes away less than half of the error.
    assert_eq!(left(100.0, 50.0, false).is_model_error(100.0), 0.5);
}

#[test]
fn where_a_model_error_is_allowed_for_the_probability_falls_with_what_the_effect_explains() {
    let left = Left { strongest: 900.0, squares: 10.0, is_allowed_for: true, is_found: false };
    for (gain, expected) in [(900.0, 1.0 / 31.0), (270.0, 0.1), (190.0, 30.0 / 220.0), (0.0, 0.5), (-5.0, 0.5)] {
        assert!((left.is_model_error(gain) - expected).abs() < 1e-12, "{gain}");
    }
    // Less than a fifth of the strongest.
    assert!((left.is_model_error(120.0) - 0.5).abs() < 1e-12);
    let none = Left { squares: 0.0, ..left };
    assert!(none.is_model_error(900.0) < 1e-12);
}
