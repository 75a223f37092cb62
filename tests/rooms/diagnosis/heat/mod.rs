//! Tests of `diagnosis/src/diagnosis/heat/mod.rs`.

use bmv::diagnosis::fits::evidence::Evidence;
use bmv::diagnosis::fits::refit::Begin;
use bmv::diagnosis::heat::sources::{Kind as SourceKind, Sources};
use bmv::diagnosis::heat::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// Where the baseline fit is distorted, it need not have come to its end: what heat explains does not depend on it. With a
/// difference to the baseline fit's evidence the two would differ by what that is wrong by.
#[test]
fn the_evidence_does_not_depend_on_where_the_believed_fit_stopped() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let begin = Begin { from_prior: 2, scale: 1.0, ..Begin::default() };
    let fitted = problem.refit(&[], &begin, &StreamKey::new(1, "test", "heat")).unwrap();
    let best = missing_heat(&problem, &fitted).unwrap();
    assert!(best.log_evidence > fitted.log_evidence + 10.0, "{} {}", best.log_evidence, fitted.log_evidence);
    let mut stopped = fitted.clone();
    for (value, held) in stopped.unknowns.iter_mut().zip(&fitted.held) {
        *value *= if *held { 1.0 } else { 1.001 };
    }
    stopped.log_evidence -= 1e6;
    let missing = missing_heat(&problem, &stopped).unwrap();
    // Both settle until half the sum of squares falls by less than 0.02, and the model is nearly linear.
    assert!((missing.log_evidence - best.log_evidence).abs() < 0.5, "{} {}", missing.log_evidence, best.log_evidence);
    assert_eq!(missing.heat.len(), best.heat.len());
    for (one, other) in missing.heat.iter().zip(&best.heat) {
        assert!((one.watts - other.watts).abs() < 0.1 * one.sd, "{one:?} {other:?}");
    }
    // Where all is nearly linear and the fit is at its end, it is the difference that it was.
    let sources = Sources::new(&problem).unwrap();
    let state = sources.at(&fitted.unknowns, &vec![0.0; sources.list().len()]).unwrap();
    let without = Evidence::new(&state.linear).log_evidence(&[]).unwrap();
    let constant = sources.constant(&state, &fitted).unwrap();
    assert!((without + constant - fitted.log_evidence).abs() < 0.05, "{without} {constant} {}", fitted.log_evidence);
}

#[test]
fn why_heat_of_unknown_origin_is_not_known_is_said() {
    use bmv::diagnosis::heat::sources::NoHeat;
    let too_many = NoHeat::TooMany.in_words();
    assert!(too_many.contains("more than 600"), "{too_many}");
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    // Few nodes, but very many phases: it is not the network that is too large.
    let own = problem.measurements[0].clone();
    problem.measurements = vec![own; 120];
    assert_eq!(Sources::new(&problem).err(), Some(NoHeat::TooMany));
    problem.measurements.truncate(1);
    problem.measurements[0].sensors[0].sigma = None;
    let why = Sources::new(&problem).err().expect("no noise").in_words();
    let name = &problem.measurements[0].sensors[0].name;
    assert!(why.contains("has no `sigma`") && why.contains(name.as_str()), "{why}");
}

/// As a run is that only the choice of effects is to be tested by.
#[test]
fn heat_is_sought_beside_a_measurement_that_is_held_out_as_a_whole() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    for kind in [TestKind::Steady, TestKind::Steps] {
        let recipe = Recipe::of(Topology::Star, kind, InjectionRequest::default());
        let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
        let alone = Sources::new(&problem).unwrap();
        let mut other = problem.measurements[0].clone();
        other.name = "held out".to_owned();
        match &mut other.rows {
            Rows::Steady(phases) => phases.iter_mut().for_each(|phase| phase.held_out = true),
            Rows::Transient { held_out, .. } => held_out.fill(true),
        }
        problem.measurements.push(other);
        let nodes = |sources: &Sources| {
            sources.list().iter().filter(|source| matches!(source.kind, SourceKind::Node(_))).count()
        };
        let both = Sources::new(&problem).unwrap();
        assert!(nodes(&alone) > 0 && nodes(&both) == nodes(&alone), "{} and {}", nodes(&both), nodes(&alone));
    }
}

/// A step is tried by its values alone, with the sources that are needed alone.
#[test]
fn half_the_square_is_that_of_the_linearisation_with_all_sources_and_with_some() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    for kind in [TestKind::Steady, TestKind::Steps] {
        let recipe = Recipe::of(Topology::Star, kind, InjectionRequest::default());
        let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
        let begin = Begin { from_prior: 2, scale: 1.0, ..Begin::default() };
        let fitted = problem.refit(&[], &begin, &StreamKey::new(1, "test", "heat")).unwrap();
        let all = Sources::new(&problem).unwrap();
        let kinds = [all.list()[1].kind, SourceKind::Sensor(0, 0)];
        let places: Vec<usize> =
            (0..all.list().len()).filter(|&place| kinds.contains(&all.list()[place].kind)).collect();
        let amplitudes: Vec<f64> = (0..all.list().len())
            .map(|place| if kinds.contains(&all.list()[place].kind) { 0.1 + 0.01 * place as f64 } else { 0.0 })
            .collect();
        let of_all = all.at(&fitted.unknowns, &amplitudes).unwrap();
        let value = all.half_square(&fitted.unknowns, &amplitudes).unwrap();
        assert!((value / of_all.half_square - 1.0).abs() < 1e-9, "{value} {}", of_all.half_square);

        let some = Sources::of(&problem, &|kind| kinds.contains(&kind)).unwrap();
        let of_some = some.list().iter().zip(places.iter().map(|&place| &all.list()[place]));
        assert_eq!(some.list().len(), places.len());
        assert!(of_some.clone().all(|(one, other)| one.kind == other.kind && one.phase == other.phase));
        let amplitudes: Vec<f64> = places.iter().map(|&place| amplitudes[place]).collect();
        let value = some.half_square(&fitted.unknowns, &amplitudes).unwrap();
        // In a transient another number of sensitivities does not move the steps; what is left is rounding.
        assert!((value / of_all.half_square - 1.0).abs() < 1e-9, "{value} {}", of_all.half_square);
        let state = some.at(&fitted.unknowns, &amplitudes).unwrap();
        let narrowed = of_all.only(&places);
        for (one, other) in state.columns.iter().zip(&narrowed.columns) {
            let largest = other.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() <= 1e-6 * largest));
        }
        assert_eq!(state.amplitudes, narrowed.amplitudes);
    }
}
