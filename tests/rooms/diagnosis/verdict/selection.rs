//! Tests of `diagnosis/src/diagnosis/verdict/selection.rs`.

use bmv::diagnosis::odds::posterior_odds::SetProbabilities;
use bmv::diagnosis::verdict::selection::*;
use bmv::math::functions::{exp, ln};

#[test]
fn a_whole_group_has_what_its_members_had() {
    let mut weights = SetProbabilities { sets: vec![0.05, 0.3, 0.5, 0.1], unexplained: 0.05 };
    give_to_whole(&mut weights, 1, &[2, 3]);
    // A single place keeps exp(-3) of what the group has.
    assert!((weights.sets[1] / (weights.sets[2] + weights.sets[3]) - exp(3.0)).abs() < 1e-9, "{weights:?}");
    assert!((weights.sets[2] / weights.sets[3] - 5.0).abs() < 1e-9);
    assert!((weights.sets.iter().sum::<f64>() + weights.unexplained - 1.0).abs() < 1e-12);
    let sure = SetProbabilities { sets: vec![0.0, 0.99, 0.01], unexplained: 0.0 };
    let mut same = sure.clone();
    give_to_whole(&mut same, 1, &[2]);
    assert_eq!(same, sure, "it has more already");
}

/// A curve at 0.8 against laws at 0.1, which predict the held-out rows 20 times as well.
#[test]
fn held_out_rows_weigh_laws_against_a_curve() {
    let weights = SetProbabilities { sets: vec![0.0, 0.8, 0.1], unexplained: 0.1 };
    let with = with_gains(&weights, &[-50.0, 0.0, ln(20.0)]);
    assert!((with.sets[1] - 0.8 / 2.9).abs() < 1e-12 && (with.sets[2] - 2.0 / 2.9).abs() < 1e-12, "{with:?}");
    assert!((with.sets.iter().sum::<f64>() + with.unexplained - 1.0).abs() < 1e-12);
    let none = SetProbabilities { sets: vec![0.0, 0.0], unexplained: 0.0 };
    assert_eq!(with_gains(&none, &[0.0, 1.0]), none, "nothing is weighed");
    assert_eq!(with_gains(&weights, &[0.0, 0.0, f64::INFINITY]), weights);
}

#[test]
fn odds_are_doubted_as_far_as_something_is_found() {
    assert_eq!(doubt(0.5, 0.01), 1.0);
    assert_eq!(doubt(0.01, 0.01), 1.0);
    // Two-sided deviates of 4.89 and 2.58.
    assert!((doubt(1e-6, 0.01) - 3.605).abs() < 0.01, "{}", doubt(1e-6, 0.01));
    assert_eq!(doubt(0.0, 0.01), 10.0);
}
