//! Tests of `diagnosis/src/diagnosis/verdict/lumped_nodes.rs`.

use bmv::diagnosis::verdict::lumped_nodes::*;
use std::sync::Arc;

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

#[test]
fn half_of_a_sensor_that_is_pulled_is_a_gradient() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let of = |name: &str| problem.candidates.iter().position(|own| own.effect == name).unwrap();
    assert!(is_like_gradient(&problem, of("sensor-conduction")));
    assert!(!is_like_gradient(&problem, of("sensor-bias")) && !is_like_gradient(&problem, of("conductive-path")));
}

#[test]
fn what_explains_three_times_the_errors_of_lumped_nodes_is_one_of_them_as_likely_as_not() {
    for (gain, expected) in [(-5.0, 0.5), (0.0, 0.5), (30.0, 0.5), (90.0, 0.25), (270.0, 0.1)] {
        assert!((probability(30.0, gain) - expected).abs() < 1e-12, "{gain}");
    }
    assert_eq!(probability(0.0, 0.0), 0.0, "where nothing varies");
}

/// Two thermometers of which one varies between 290 and 310 K and the other is at rest; a constant added changes nothing.
#[test]
fn the_variation_is_that_of_the_middle_thermometer() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let mut over = |swing_k: f64, of: fn(usize) -> f64| {
        for measurement in &mut problem.measurements {
            let sensors = measurement.sensors.len();
            for (place, reading) in measurement.readings.iter_mut().enumerate() {
                let up = if place / sensors % 2 == 0 { swing_k } else { -swing_k };
                *reading = Some(300.0 + of(place % sensors) * up);
            }
        }
        let readings = problem.fitted_readings();
        typical_variation_k(&problem, &readings)
    };
    let all = over(10.0, |_| 1.0);
    assert!((all - 10.0).abs() < 0.5, "{all}: rows are nearly as often up as down");
    assert!(over(10.0, |sensor| if sensor == 0 { 100.0 } else { 1.0 }) < 10.5, "one that swings far is not the middle");
    assert_eq!(over(0.0, |_| 1.0), 0.0);
}
