//! Tests of `diagnosis/src/diagnosis/odds/medium.rs`.

use bmv::diagnosis::Problem;
use bmv::diagnosis::odds::medium::*;
use bmv::diagnosis::odds::prior_odds::PriorOdds;
use bmv::document::Diagnostics;
use bmv::effect::{Bound, Catalogue};
use bmv::math::functions::ln;
use bmv::measurement::Rows;
use bmv::thermal::NodeKind;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// A star in a chamber full of air, everything at 290 K.
fn warm() -> Problem {
    at(290.0)
}

/// The same with everything at another temperature, K.
fn at(everywhere: f64) -> Problem {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let mut model = (*problem.model).clone();
    let room = model.graph.number(everywhere);
    for node in &mut model.nodes {
        if let NodeKind::Boundary { temperature } = &mut node.kind
            && model.graph.symbols(*temperature).is_empty()
        {
            *temperature = room;
        }
    }
    problem.model = Arc::new(model);
    let inputs = problem.model.inputs.clone();
    for measurement in &mut problem.measurements {
        let Rows::Steady(phases) = &mut measurement.rows else { panic!("steady phases") };
        for phase in phases {
            for (value, input) in phase.inputs.iter_mut().zip(&inputs) {
                match input.unit.as_str() {
                    "K" => *value = everywhere,
                    "Pa" => *value = 1e5,
                    _ => {}
                }
            }
        }
    }
    problem
}

fn set(problem: &mut Problem, name: &str, value: f64) {
    let input = problem.model.inputs.iter().position(|input| input.name == name).unwrap();
    let Rows::Steady(phases) = &mut problem.measurements[0].rows else { panic!("steady phases") };
    phases[0].inputs[input] = value;
}

fn id_odds(problem: &Problem, effect: &str) -> f64 {
    let candidate = problem.candidates.iter().position(|own| own.effect == effect).unwrap();
    PriorOdds::new(problem).of(problem, &[candidate])
}

#[test]
fn a_cold_shroud_tells_of_vacuum_and_convection_is_improbable_there() {
    let mut problem = warm();
    assert!(!is_vacuum(&problem));
    let alike = id_odds(&problem, "convection") - id_odds(&problem, "conductive-path");
    set(&mut problem, "T_shroud", 120.0);
    assert!(!is_vacuum(&problem));
    set(&mut problem, "T_shroud", 80.0);
    assert!(is_vacuum(&problem));
    let behind = id_odds(&problem, "convection") - id_odds(&problem, "conductive-path");
    assert!((alike - behind - 3.0).abs() < 1e-12, "{alike} {behind}");
}

#[test]
fn a_low_pressure_tells_of_vacuum_and_is_no_source_of_heat() {
    let mut problem = warm();
    let heater = problem.model.inputs.iter().position(|input| input.unit == "W").unwrap();
    let mut model = (*problem.model).clone();
    model.inputs[heater].unit = "mbar".to_owned();
    let name = model.inputs[heater].name.clone();
    let of_it = |problem: &Problem| {
        let own = |own: &bmv::effect::Candidate| {
            own.effect == "input-proportional-load" && own.bound == [Bound::Input(heater)]
        };
        let candidate = problem.candidates.iter().position(own).unwrap();
        PriorOdds::new(problem).of(problem, &[candidate])
    };
    let before = of_it(&problem);
    problem.model = Arc::new(model);
    let Rows::Steady(phases) = &mut problem.measurements[0].rows else { panic!("steady phases") };
    phases.iter_mut().for_each(|phase| phase.inputs[heater] = 1e-3);
    assert!(is_vacuum(&problem));
    set(&mut problem, &name, 1e5);
    assert!(!is_vacuum(&problem), "one phase in air");
    assert!((before - of_it(&problem) - 3.0).abs() < 1e-12 && before > ln(1e-6));
}

/// Heat goes with the difference of two temperatures; a conductance may well go with one.
#[test]
fn a_temperature_is_no_cause_of_heat() {
    let mut problem = warm();
    let heater = problem.model.inputs.iter().position(|input| input.unit == "W").unwrap();
    let odds = |problem: &Problem, effect: &str| {
        let own = |own: &bmv::effect::Candidate| own.effect == effect && own.bound == [Bound::Input(heater)];
        PriorOdds::new(problem).of(problem, &[problem.candidates.iter().position(own).unwrap()])
    };
    let effects = ["input-proportional-load", "input-function-load", "input-dependent-conductance"];
    let before = effects.map(|effect| odds(&problem, effect));
    let mut model = (*problem.model).clone();
    model.inputs[heater].unit = "degC".to_owned();
    problem.model = Arc::new(model);
    let behind: Vec<f64> = effects.iter().zip(before).map(|(effect, before)| before - odds(&problem, effect)).collect();
    // That a conductance goes with a power, as before, is less probable by itself.
    for (own, expected) in behind.iter().zip([3.0, 3.0, -1.5]) {
        assert!((own - expected).abs() < 1e-12, "{behind:?}");
    }
}

#[test]
fn surroundings_that_are_warmer_than_all_else_stand_for_a_source() {
    let room = warm();
    assert!(!is_source(&room, 292.0), "the wall of a room");
    assert!(is_source(&room, 296.0));
    // The room about a cold chamber is no boundary of its model.
    let chamber = at(100.0);
    assert!(!is_source(&chamber, 295.0) && is_source(&chamber, 310.0));
}
