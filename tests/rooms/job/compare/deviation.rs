//! Tests of `src/job/compare/deviation.rs`.

use bmv::job::compare::deviation::*;
use bmv::job::compare::output::Deviation;

#[test]
fn statistics_of_four_numbers() {
    let d = deviation(&[1.0, -1.0, 3.0, 1.0], Some(1.0));
    assert_eq!((d.count, d.mean, d.max, d.within_limit), (4, 1.0, 3.0, 0.75));
    // By hand: squares about the mean 0, 4, 4, 0 over 3; squares 1, 1, 9, 1 over 4.
    assert!((d.sd - (8.0f64 / 3.0).sqrt()).abs() < 1e-15);
    assert!((d.rmse - 3.0f64.sqrt()).abs() < 1e-15);
}

#[test]
fn nothing_gives_zeros_and_one_reading_no_spread() {
    assert_eq!(deviation(&[], None), Deviation::default());
    assert_eq!(deviation(&[2.0], None).sd, 0.0);
}
