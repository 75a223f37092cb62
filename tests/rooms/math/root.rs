//! Tests of `core/src/math/root.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::root::*;

#[test]
fn finds_known_roots_in_few_evaluations() {
    let mut count = 0;
    let root = brent(
        |x| {
            count += 1;
            x.cos() - x
        },
        0.0,
        1.0,
        1e-15,
        100,
    );
    // The Dottie number.
    assert!((root.unwrap() - 0.739_085_133_215_160_6).abs() < 1e-15);
    assert!(count < 12, "{count} evaluations");
    let root = brent(|x| x * x * x - 2.0 * x - 5.0, 3.0, 2.0, 1e-14, 100).unwrap();
    assert!((root - 2.094_551_481_542_326_6).abs() < 1e-14, "Wallis's example, bracket turned round");
    assert!(brent(|x| x.powi(9), -1.0, 4.0, 1e-9, 200).unwrap().abs() < 1e-9);
    assert_eq!(brent(|x| x - 1.0, 1.0, 2.0, 0.0, 5), Ok(1.0));
    assert_eq!(brent(|x| x - 2.0, 1.0, 2.0, 0.0, 5), Ok(2.0));
}

#[test]
fn newton_stays_in_its_bracket() {
    // atan's Newton iteration diverges from 2 without the bracket.
    let root = newton_increasing(|x: f64| (x.atan(), 1.0 / (1.0 + x * x)), -5.0, 50.0, 2.0, 100).unwrap();
    assert!(root.abs() < 1e-15);
    let root = newton_increasing(|x| (x * x - 2.0, 2.0 * x), 0.0, 2.0, 9.0, 100).unwrap();
    assert!((root - 2_f64.sqrt()).abs() < 4e-16);
    assert!(newton_increasing(|_| (f64::NAN, 1.0), 0.0, 1.0, 0.5, 100).is_err());
}

#[test]
fn failures_are_told_apart() {
    assert!(matches!(brent(|x| x * x + 1.0, -1.0, 1.0, 0.0, 50), Err(RootError::NoBracket { at_lower: 2.0, .. })));
    let error = brent(|x| if x > 1.9 { f64::NAN } else { -1.0 }, 0.0, 2.0, 0.0, 50);
    assert!(matches!(error, Err(RootError::NotFinite { at: 2.0, .. })));
    assert!(matches!(brent(f64::atan, -1.0, 3.0, 0.0, 2), Err(RootError::NotConverged { iterations: 2, .. })));
}
