//! Tests of `src/study/posterior_prior.rs`.

use bmv::study::posterior_prior::*;
use serde_json::{Value, json};

fn unfilled() -> PosteriorPrior {
    PosteriorPrior {
        source: "`tuned` of `pass-1.json`".into(),
        parameters: vec![3, 1],
        names: vec!["b".into(), "a".into()],
        sha256: None,
        draws: vec![],
        effective: 0.0,
        converged: false,
    }
}

fn result() -> Value {
    json!({"converged": true, "order": ["a", "b", "m.s.sigma"],
           "parameters": {"a": {"ess_bulk": 900.0, "ess_tail": 2.5}, "b": {"ess_bulk": 800.0, "ess_tail": 700.0}},
           "draws": {"values": [[1.0, 10.0, 0.1], [2.0, 20.0, 0.1], [3.0, 30.0, 0.2]]}})
}

#[test]
fn draws_are_taken_by_name_and_stay_together() {
    let filled = unfilled().filled(&result()).expect("draws");
    assert_eq!(filled.draws, [[10.0, 1.0], [20.0, 2.0], [30.0, 3.0]]);
    assert_eq!((filled.effective, filled.converged), (2.5, true));
    assert_eq!([0.0, 0.34, 0.67, 1.0].map(|share| filled.position(share)), [0, 1, 2, 2]);
    assert_eq!(filled.identity(), unfilled().identity(), "known before the calibration ran");
}

#[test]
fn a_result_that_lacks_a_parameter_is_refused() {
    let mut other = unfilled();
    other.names[0] = "c".into();
    let error = other.filled(&result()).expect_err("no draws of it").to_string();
    assert_eq!(error, "the posterior of `tuned` of `pass-1.json`: `c` was not inferred");
    assert!(unfilled().filled(&json!({})).is_err());
}
