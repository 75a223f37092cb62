//! Tests of `src/job/compare/tuned.rs`.

use bmv::job::compare::deviation::common_unit;
use bmv::job::compare::tuned::*;
use bmv::job::compare::{Readings, Row};
use bmv::thermal::Model;

#[test]
fn a_result_without_a_tuned_state_is_refused() {
    let good = serde_json::json!({"tuned": [["G", 0.5], ["m.s.sigma", 0.1]], "converged": true});
    assert_eq!(Tuned::from_result("fit", &good).unwrap().find("G"), Some(0.5));
    let error = Tuned::from_result("fit", &serde_json::json!({})).unwrap_err().to_string();
    assert!(error.starts_with("the result of `fit` has no tuned state"), "{error}");
}

#[test]
fn kelvins_and_amperes_have_no_mean() {
    let row = |unit: &str, measured: f64| Row {
        measurement: "m".into(),
        phase: Some("P".into()),
        time_s: None,
        sensor: unit.into(),
        unit: unit.into(),
        measured,
        predicted: 0.0,
        predicted_tuned: Some(0.0),
        held_out: false,
    };
    let readings: Readings = [row("A", 100.0), row("K", 3.0), row("K", -4.0)].into_iter().collect();
    let unit = common_unit(readings.iter());
    let judged = || readings.iter().filter(|row| row.unit == unit);
    let tuned = Tuned { job: "fit".into(), values: vec![], unknowns: 0, converged: true };
    let state = tuned.state(&Model::default(), &[], judged, None);
    // By hand: the root of (9 + 16) / 2.
    assert_eq!((unit, state.train.count, state.train.rmse), ("K", 2, 12.5f64.sqrt()));
}
