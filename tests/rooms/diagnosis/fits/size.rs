//! Tests of `diagnosis/src/diagnosis/fits/size.rs`.

use bmv::diagnosis::fits::refit::{Begin, Refit};
use bmv::diagnosis::fits::size::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::expression::Unit;
use bmv::measurement::prediction::RowHeat;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

#[test]
fn a_watt_that_goes_through_a_network_is_counted_once() {
    // 3 W of a source, of which 1 W stays.
    let warming = RowHeat { sources_w: 3.0, into_boundaries_w: vec![(0, 2.0)], stored_w: 1.0 };
    assert_eq!(moved(&warming), 3.0);
    // 5 W from a warm boundary to a cold one, nothing else.
    let between = RowHeat { sources_w: 0.0, into_boundaries_w: vec![(0, -5.0), (1, 5.0)], stored_w: 0.0 };
    assert_eq!(moved(&between), 5.0);
}

#[test]
fn units_of_heat_and_areas_are_of_hardware_factors_are_not() {
    let of = |text: &str| is_of_hardware(Unit::parse(text).expect("a unit").dimension);
    for text in ["W", "mW", "W/K", "W/K^1.25", "J/K", "kJ/K", "m2", "W/A", "ohm"] {
        assert!(of(text), "{text}");
    }
    for text in ["1", "%", "1/K", "K", "K/s", "s"] {
        assert!(!of(text), "{text}");
    }
}

/// A steady star with a heat of so many watts, which the catalogue takes for about 1 W, refitted with it.
fn refitted(watts: f64) -> Refit {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), amplitude: Some(watts), ..InjectionRequest::default() };
    let case = case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, request), 1, 0).unwrap();
    let is_true = |id: &String| case.truth.effects.iter().any(|effect| effect.id == *id);
    let effect = case.problem.candidates.iter().position(|candidate| is_true(&candidate.id)).unwrap();
    let begin = Begin { from_prior: 2, scale: 1.0, ..Begin::default() };
    case.problem.refit(&[effect], &begin, &StreamKey::new(1, "test", "size")).unwrap()
}

#[test]
fn a_heat_far_beyond_the_catalogue_is_plausible_only_where_the_model_moves_as_much() {
    let [small, large] = [8.0, 300.0].map(refitted);
    assert!(small.within_model[0] && !small.is_implausible(small.effects[0]));
    assert!(!large.within_model[0] && large.is_implausible(large.effects[0]));
}
