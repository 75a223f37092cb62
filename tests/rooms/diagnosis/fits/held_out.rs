//! Tests of `core/src/diagnosis/fits/held_out.rs`.

use bmv::diagnosis::fits::held_out::*;

#[test]
fn gains_without_a_number_are_no_test() {
    assert_eq!(mean_gain(&[1.0, 3.0]), Some((2.0, Some(1.0))));
    assert_eq!(mean_gain(&[5.0]), Some((5.0, None)), "one block has no standard error");
    // Errors of 10 K by a noise of 1e-154 K.
    assert_eq!((mean_gain(&[]), mean_gain(&[f64::INFINITY, 1.0]), mean_gain(&[1e200, -1e200])), (None, None, None));
}

#[test]
fn errors_that_double_beyond_the_noise_are_bad() {
    // 1.2 to 7.2 K; 1.3 to 2.4 K is less than twice.
    let (doubled, risen) = ([1.2 * 1.2, 7.2 * 7.2], [1.3 * 1.3, 2.4 * 2.4]);
    assert!(is_bad(Some(1e-9), false, doubled) && !is_bad(Some(1e-9), false, risen));
    assert!(!is_bad(Some(0.01), false, doubled), "what the fitted rows leave open is no fault");
    assert!(!is_bad(None, true, doubled) && is_bad(Some(1e-9), true, risen));
}
