//! Tests of `core/src/measurement/prediction.rs`.

use std::sync::Arc;

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::measurement::prediction::Predictor;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

/// A bound that is never reached changes no bit; one that is leaves no prediction, and a reason.
#[test]
fn a_transient_that_takes_more_steps_than_its_rows_allow_has_no_prediction() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steps, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let measurement = problem.measurements.iter().find(|own| matches!(own.rows, Rows::Transient { .. })).unwrap();
    let nominal: Vec<f64> = problem.model.parameters.iter().map(|own| own.nominal).collect();
    let predicted = |most_steps_a_row: Option<u64>| {
        let predictor = Predictor::new(&problem.model, &[]).unwrap().with_most_steps_a_row(most_steps_a_row);
        predictor.predict(&mut predictor.workspace(), measurement, &nominal)
    };
    let free = predicted(None);
    assert!(free.failures.is_empty() && free.readings.iter().all(|reading| reading.is_finite()));
    assert_eq!(predicted(Some(5000)).readings, free.readings);
    let given_up = predicted(Some(0));
    assert!(given_up.readings.iter().all(|reading| reading.is_nan()));
    assert!(matches!(&given_up.failures[..], [(None, reason)] if reason.contains("step")), "{:?}", given_up.failures);
}
