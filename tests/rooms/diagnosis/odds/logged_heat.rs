//! Tests of `diagnosis/src/diagnosis/odds/logged_heat.rs`.

use bmv::diagnosis::Problem;
use bmv::diagnosis::odds::prior_odds::PriorOdds;
use bmv::document::Diagnostics;
use bmv::effect::{Bound, Catalogue};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// Log odds of an effect on an input at its first place, where the input has this unit.
fn odds(problem: &Problem, effect: &str, input: usize, unit: &str) -> f64 {
    let mut problem = problem.clone();
    Arc::make_mut(&mut problem.model).inputs[input].unit = unit.to_owned();
    let own = |own: &bmv::effect::Candidate| own.effect == effect && own.bound == [Bound::Input(input)];
    let candidate = problem.candidates.iter().position(own).unwrap();
    PriorOdds::new(&problem).of(&problem, &[candidate])
}

#[test]
fn heat_in_proportion_to_a_logged_power_that_the_model_does_not_use_is_likelier() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    // The heater is a load of this model; without its elements the model uses no input.
    let mut without_loads = problem.clone();
    Arc::make_mut(&mut without_loads.model).elements.clear();
    let heater = problem.model.inputs.iter().position(|input| input.unit == "W").unwrap();
    let gain = |problem: &Problem, effect: &str, unit: &str| {
        odds(problem, effect, heater, unit) - odds(problem, effect, heater, "A")
    };
    for (unit, expected) in [("W", 1.5), ("kW", 1.5), ("W/m^2", 1.5), ("V", 0.0), ("m/s", 0.0)] {
        let gained = gain(&without_loads, "input-proportional-load", unit);
        assert!((gained - expected).abs() < 1e-12, "{unit}: {gained}");
        assert_eq!(gain(&problem, "input-proportional-load", unit), 0.0, "{unit} that heats something already");
    }
    for effect in ["joule-heating", "input-dependent-conductance"] {
        assert_eq!(gain(&without_loads, effect, "W"), 0.0, "{effect}");
    }
}

#[test]
fn a_logged_power_that_follows_temperature_is_less_likely() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let logged: Vec<usize> =
        (0..problem.model.inputs.len()).filter(|&at| problem.model.inputs[at].unit == "W").collect();
    let odds = |effect: &str, unit: &str| {
        let mut problem = problem.clone();
        let model = Arc::make_mut(&mut problem.model);
        logged.iter().for_each(|&input| model.inputs[input].unit = unit.to_owned());
        let is_own = |own: &bmv::effect::Candidate| own.effect == effect && !own.is_group();
        let candidate = problem.candidates.iter().position(is_own).unwrap();
        PriorOdds::new(&problem).of(&problem, &[candidate])
    };
    for (effect, unit, expected) in [
        ("dissipation-temperature", "W", 1.5),
        ("dissipation-temperature", "W/m^2", 0.0),
        ("dissipation-temperature", "A", 0.0),
        ("heater-efficiency", "W", 0.0),
        ("temperature-dependent-conductance", "W", 0.0),
    ] {
        let lost = odds(effect, "V") - odds(effect, unit);
        assert!((lost - expected).abs() < 1e-12, "{effect} of {unit}: {lost}");
    }
}
