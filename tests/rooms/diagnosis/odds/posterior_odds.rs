//! Tests of `diagnosis/src/diagnosis/odds/posterior_odds.rs`.

use bmv::diagnosis::fits::refit::{Begin, HeldOut};
use bmv::diagnosis::odds::posterior_odds::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::math::functions::ln;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

#[test]
fn nothing_stands_while_no_test_is_clear_and_no_set_takes_its_probability() {
    assert!(nothing_stands(1.0, 0.9) && nothing_stands(1.0, 0.005) && nothing_stands(0.3, 0.005));
    // 1 / (1 / 0.2 + 0.0526 / 0.072) = 0.17; at p = 1e-4 an alternative may be 400 times as likely.
    assert!(!nothing_stands(0.2, 0.005) && !nothing_stands(1.0, 1e-4) && !nothing_stands(1.0, 0.0));
}

/// A curve at 0.9 and, once it is gone, another at 1e-4 are vetoed; what is left is 0.08 + 0.01 + 0.0099.
#[test]
fn vetoed_sets_go_to_something_else_or_out_of_the_question() {
    let weights = SetProbabilities { sets: vec![0.0, 0.9, 0.08, 1e-4, 0.01], unexplained: 0.0099 };
    let found = veto(&weights, 2e-3, |set| set == 1 || set == 3);
    assert_eq!(found.sets, [1]);
    assert!((found.with.unexplained - 0.9099).abs() < 1e-12 && found.with.sets[2] == 0.08);
    let found = veto(&weights, 5e-4, |set| set == 1 || set == 3);
    assert_eq!(found.sets, [1, 3], "1e-4 / 0.1 is above the least");
    assert!((found.without.sets[2] - 0.08 / 0.0999).abs() < 1e-12, "{found:?}");
    assert!((found.without.unexplained - 0.0099 / 0.0999).abs() < 1e-12);
    let nothing = veto(&weights, 1e-3, |_| false);
    assert_eq!((nothing.with, nothing.without), (weights.clone(), weights));
}

/// Four held-out readings, predicted with half the error, are worth `4 ln 2`.
#[test]
fn held_out_readings_join_the_odds() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    let problem =
        case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, request), 1, 0).expect("a case").problem;
    let begin = Begin { from_prior: 2, scale: 1.0, ..Begin::default() };
    let refit = |effects: &[usize], rmse_held_out_k: f64| {
        let mut refit = problem.refit(effects, &begin, &StreamKey::new(1, "test", "odds")).expect("a fit");
        refit.held_out = vec![HeldOut { measurement: 0, row: 0, sensor: 0, error: 0.0, sigma: 1.0 }; 4];
        refit.rmse_held_out_k = Some(rmse_held_out_k);
        refit
    };
    let refits = [refit(&[], 0.8), refit(&[0], 0.4)];
    let log_odds = |weights: SetProbabilities| ln(weights.sets[1] / weights.sets[0]);
    let gain = log_odds(odds_with_held_out(&problem, &refits)) - log_odds(posterior_odds(&problem, &refits, None));
    assert!((gain - 4.0 * ln(2.0)).abs() < 1e-9, "{gain}");
}
