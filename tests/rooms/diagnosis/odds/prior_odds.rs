//! Tests of `diagnosis/src/diagnosis/odds/prior_odds.rs`.

use bmv::diagnosis::odds::prior_odds::*;
use bmv::document::Diagnostics;
use bmv::effect::{Bound, Catalogue, Site};
use bmv::math::functions::ln;
use bmv::measurement::Rows;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// Half a day halves the odds of what changes at a date, of a record of minutes a hundredth is left; steady phases keep them.
#[test]
fn a_change_at_a_date_is_less_probable_in_a_short_record() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = |kind| Recipe::of(Topology::Star, kind, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe(TestKind::Steps), 1, 0).unwrap().problem;
    let mut over = |seconds: f64| {
        let count = problem.measurements.len() as f64;
        for measurement in &mut problem.measurements {
            let Rows::Transient { inputs, .. } = &mut measurement.rows else { panic!("a transient") };
            let rows = inputs.times_s.len() as f64 - 1.0;
            let time = |row: usize| row as f64 * seconds / count / rows;
            inputs.times_s.iter_mut().enumerate().for_each(|(row, own)| *own = time(row));
        }
        log_share_of_changes(&problem.measurements)
    };
    assert!((over(43_200.0) - ln(0.5)).abs() < 1e-9);
    assert!((over(60.0) - ln(0.01)).abs() < 1e-9);
    assert_eq!(over(1e6), 0.0);
    let steady = case(&catalogue, &recipe(TestKind::Steady), 1, 0).unwrap().problem;
    assert_eq!(log_share_of_changes(&steady.measurements), 0.0);
}

/// A kind that is held for likely gains the ratio of its odds to the conventional 1/19 at each of its places, others nothing.
#[test]
fn the_study_may_say_how_probable_a_kind_of_effect_is() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let mut problem =
        case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default()), 1, 0)
            .unwrap()
            .problem;
    let of = |effect: &str| problem.candidates.iter().position(|own| own.effect == effect).unwrap();
    let (load, path) = (of("heat-load"), of("conductive-path"));
    let before = PriorOdds::new(&problem);
    problem.missing_probability.insert("heat-load".to_owned(), 0.5);
    let after = PriorOdds::new(&problem);
    let gain = |effects: &[usize]| after.of(&problem, effects) - before.of(&problem, effects);
    assert!((gain(&[load]) - ln(19.0)).abs() < 1e-12 && gain(&[path]) == 0.0);
    assert!((gain(&[load, path]) - ln(19.0)).abs() < 1e-12);
}

/// A twentieth of the odds of another kind with as many places; a study that says 0.05 itself has what that says.
#[test]
fn what_needs_something_rare_is_a_twentieth_as_probable() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let places = |effect: &str| problem.candidates.iter().filter(|own| own.effect == effect).count() as f64;
    let fewer = ln(places("evaporation") / places("heat-load"));
    let of = |effect: &str| problem.candidates.iter().position(|own| own.effect == effect).unwrap();
    let (load, evaporation) = (of("heat-load"), of("evaporation"));
    let odds = PriorOdds::new(&problem);
    let behind = odds.of(&problem, &[load]) - odds.of(&problem, &[evaporation]) - fewer;
    assert!((behind - 3.0).abs() < 1e-12, "{behind}");
    problem.missing_probability.insert("evaporation".to_owned(), 0.05);
    let odds = PriorOdds::new(&problem);
    let behind = odds.of(&problem, &[load]) - odds.of(&problem, &[evaporation]) - fewer;
    assert!(behind.abs() < 1e-12, "{behind}");
}

/// A path that follows what warms is exp(-1.5) times as probable as one that follows a flow; a load that does is as probable as another.
#[test]
fn a_path_rather_follows_a_flow_than_a_power_an_electric_current_or_a_frequency_of_electronics() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let heater = problem.model.inputs.iter().position(|input| input.unit == "W").unwrap();
    let at = |effect: &str, is_path: bool| {
        let is_here = |own: &bmv::effect::Candidate| {
            let Site::Elements(elements) = &own.site else { return false };
            let is = elements.iter().all(|&element| problem.model.elements[element].physics().between().is_some());
            own.effect == effect && own.bound == [Bound::Input(heater)] && is == is_path
        };
        problem.candidates.iter().position(is_here).unwrap()
    };
    let gain_to = |candidate: usize, unit: &str, nominal: f64, most: Option<f64>| {
        let mut other = problem.clone();
        let input = &mut Arc::make_mut(&mut other.model).inputs[heater];
        (input.unit, input.nominal, input.range) = (unit.to_owned(), nominal, most.map(|most| [0.0, most]));
        let of = |problem: &_| PriorOdds::new(problem).of(problem, &[candidate]);
        of(&other) - of(&problem)
    };
    let gain = |candidate: usize, unit: &str| gain_to(candidate, unit, 10.0, None);
    for effect in ["input-dependent-conductance", "conductance-step"] {
        let path = at(effect, true);
        for (unit, expected) in [("A", 0.0), ("W/m^2", 0.0), ("kg/s", 1.5), ("m/s", 1.5), ("degC", 1.5), ("V", 1.5)] {
            let gained = gain(path, unit);
            assert!((gained - expected).abs() < 1e-12, "{effect}, {unit}: {gained}");
        }
        // Electronics, and fans.
        for (nominal_hz, most_hz, expected) in
            [(1.0, Some(1e6), 0.0), (2e9, None, 0.0), (1e9, Some(9e5), 1.5), (100.0, None, 1.5)]
        {
            let gained = gain_to(path, "Hz", nominal_hz, most_hz);
            assert!((gained - expected).abs() < 1e-12, "{effect}, {nominal_hz} Hz, {most_hz:?}: {gained}");
        }
    }
    assert_eq!(gain(at("input-dependent-load", false), "kg/s"), 0.0);
}
