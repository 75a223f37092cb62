//! Tests of `diagnosis/src/diagnosis/verdict/small_effects.rs`.

use std::sync::Arc;

use bmv::diagnosis::verdict::small_effects::{Left, is_curve_of_few_phases};
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

#[test]
fn an_effect_may_be_model_error_beside_a_stronger_one_or_beside_what_is_left() {
    let left = |strongest, squares, is_found| Left { strongest, squares, is_allowed_for: false, is_found };
    assert_eq!(left(100.0, 10.0, false).is_model_error(100.0), 0.0);
    // Two effects of one size.
    assert_eq!(left(60.0, 0.0, false).is_model_error(40.0), 0.0);
    // But where something is left, the lesser one may be model error; the strongest is not.
    assert_eq!(left(60.0, 0.0, true).is_model_error(40.0), 0.5);
    assert_eq!(left(60.0, 0.0, true).is_model_error(60.0), 0.0);
    // A third of the strongest in readings is a ninth in squares.
    assert_eq!(left(100.0, 0.0, false).is_model_error(11.0), 0.5);
    // It takes away less than half of the error.
    assert_eq!(left(100.0, 50.0, false).is_model_error(100.0), 0.5);
}

#[test]
fn where_a_model_error_is_allowed_for_the_probability_falls_with_what_the_effect_explains() {
    let left = Left { strongest: 900.0, squares: 10.0, is_allowed_for: true, is_found: false };
    for (gain, expected) in [(900.0, 1.0 / 31.0), (270.0, 0.1), (190.0, 30.0 / 220.0), (0.0, 0.5), (-5.0, 0.5)] {
        assert!((left.is_model_error(gain) - expected).abs() < 1e-12, "{gain}");
    }
    // Less than a fifth of the strongest.
    assert!((left.is_model_error(120.0) - 0.5).abs() < 1e-12);
    let none = Left { squares: 0.0, ..left };
    assert!(none.is_model_error(900.0) < 1e-12);
}

/// Curves of five values: ten phases are two for each.
#[test]
fn a_curve_of_few_phases_is_one_of_fewer_than_two_for_each_value() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
    let drawn = |test| case(&catalogue, &Recipe::of(Topology::Star, test, request.clone()), 1, 0).unwrap().problem;
    let mut problem = drawn(TestKind::Steady);
    let find = |effect: &str| problem.candidates.iter().position(|own| own.effect == effect).unwrap();
    let (curve, law) = (find("input-function-load"), find("input-proportional-load"));
    let measurement = &mut problem.measurements[0];
    let readings = measurement.readings.len() / measurement.len();
    let Rows::Steady(phases) = &mut measurement.rows else { panic!("steady phases") };
    let mut phase = phases[0].clone();
    phase.held_out = false;
    *phases = vec![phase; 10];
    measurement.readings = vec![Some(300.0); 10 * readings];
    assert!(!is_curve_of_few_phases(&problem, curve));
    let Rows::Steady(phases) = &mut problem.measurements[0].rows else { panic!("steady phases") };
    phases[3].held_out = true;
    assert!(is_curve_of_few_phases(&problem, curve) && !is_curve_of_few_phases(&problem, law));
    let problem = drawn(TestKind::Steps);
    let curve = problem.candidates.iter().position(|own| own.effect == "input-function-load").unwrap();
    assert!(!is_curve_of_few_phases(&problem, curve), "a transient has many rows");
}
