//! Tests of `diagnosis/src/diagnosis/engine.rs`.

use bmv::diagnosis::Settings;
use bmv::diagnosis::engine::{Diagnosis, FitRequest, SensorNoise, State};
use bmv::diagnosis::noise::estimate::EstimatedNoise;
use bmv::diagnosis::noise::model_error::ModelError;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A diagnosis in the second regime whose baseline fit lies at these quantiles of its priors, in turn.
fn fitted_at(quantiles: [f64; 2], kind: TestKind) -> (Diagnosis, State) {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let problem =
        case(&catalogue, &Recipe::of(Topology::Star, kind, InjectionRequest::default()), 1, 0).unwrap().problem;
    let diagnosis = Diagnosis::new(problem, Settings::default(), StreamKey::new(1, "test", "starts"));
    let mut state = diagnosis.screen().unwrap();
    let model_error = Some(ModelError { sd: 0.5, counts_as: 0.5 });
    state.noise = vec![SensorNoise { measurement: 0, sensor: 0, noise: EstimatedNoise::white(0.1), model_error }];
    let priors: Vec<_> = diagnosis.problem().parameters.iter().map(|&at| &diagnosis.problem().priors[at]).collect();
    for ((value, prior), quantile) in state.refits[0].unknowns.iter_mut().zip(&priors).zip(quantiles.iter().cycle()) {
        *value = prior.quantile(*quantile);
    }
    (diagnosis, state)
}

fn start_of(name: &str, value: f64) -> BTreeMap<String, f64> {
    BTreeMap::from([(name.to_owned(), value)])
}

#[test]
fn a_single_effect_starts_from_the_medians_too_where_the_baseline_fit_is_far_from_them() {
    let (diagnosis, state) = fitted_at([0.999, 0.4], TestKind::Steady);
    let fitted = state.refits[0].by_name();
    let request = FitRequest { effects: vec![0], starts: vec![start_of("load", 3.0)], from: 0 };
    let starts = diagnosis.starts(diagnosis.problem(), &state, &request);
    assert_eq!(starts.len(), 2);
    for (name, value) in &fitted {
        assert_eq!(starts[0][name], *value);
    }
    for (&at, name) in diagnosis.problem().parameters.iter().zip(&state.refits[0].names) {
        assert_eq!(starts[1][name], diagnosis.problem().priors[at].quantile(0.5), "{name}");
    }
    assert!(starts.iter().all(|start| start["load"] == 3.0));
    // A start that states the parameters, as one from a screening at the medians, stays the only one.
    let stated = FitRequest { starts: vec![start_of(&state.refits[0].names[0], 1.0)], ..request.clone() };
    assert_eq!(diagnosis.starts(diagnosis.problem(), &state, &stated).len(), 1);
    // So do larger sets, and those that go on from another fit.
    let larger = FitRequest { effects: vec![0, 1], ..request.clone() };
    assert_eq!(diagnosis.starts(diagnosis.problem(), &state, &larger).len(), 1);
    // Where no model error is allowed for, points of the priors are starts already.
    let mut stated_noise = state.clone();
    stated_noise.noise[0].model_error = None;
    assert_eq!(diagnosis.starts(diagnosis.problem(), &stated_noise, &request).len(), 1);
}

#[test]
#[ignore = "thorough"]
fn where_the_baseline_fit_is_probable_its_parameters_are_the_only_start() {
    let (diagnosis, state) = fitted_at([0.9, 0.1], TestKind::Steady);
    let request = FitRequest { effects: vec![0], starts: vec![start_of("load", 3.0)], from: 0 };
    assert_eq!(diagnosis.starts(diagnosis.problem(), &state, &request).len(), 1);
}

#[test]
#[ignore = "thorough"]
fn fits_of_long_transients_start_at_the_baseline_fit_alone() {
    let (diagnosis, state) = fitted_at([0.999, 0.4], TestKind::Orbit);
    let request = FitRequest { effects: vec![0], starts: vec![start_of("load", 3.0)], from: 0 };
    assert_eq!(diagnosis.starts(diagnosis.problem(), &state, &request).len(), 2);
    let mut problem = diagnosis.problem().clone();
    for measurement in &mut problem.measurements {
        let width = measurement.sensors.len();
        let Rows::Transient { inputs, held_out, ignored, .. } = &mut measurement.rows else { continue };
        let end = *inputs.times_s.last().unwrap();
        inputs.times_s.extend((1..=1001).map(|row| end + 60.0 * f64::from(row)));
        for column in &mut inputs.columns {
            let last = *column.values.last().unwrap();
            column.values.resize(inputs.times_s.len(), last);
        }
        held_out.resize(inputs.times_s.len(), false);
        ignored.resize(inputs.times_s.len(), None);
        measurement.readings.resize(width * inputs.times_s.len(), Some(290.0));
    }
    assert_eq!(diagnosis.starts(&problem, &state, &request).len(), 1);
}
