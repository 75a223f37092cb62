//! Tests of `diagnosis/src/diagnosis/linearisation/threshold_levels.rs`.

use std::sync::Arc;

use bmv::diagnosis::linearisation::threshold_levels::is_crossed;
use bmv::document::Diagnostics;
use bmv::effect::{Bound, Catalogue};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

/// A thermostat that every reading of its node lies above or below switches nothing.
#[test]
fn a_threshold_that_no_reading_of_its_node_reaches_is_not_crossed() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
    for (kind, reach) in [(TestKind::Steady, 0.0), (TestKind::Steps, 0.05)] {
        let problem = case(&catalogue, &Recipe::of(Topology::Star, kind, request.clone()), 1, 0).unwrap().problem;
        let mut readings: Vec<f64> = Vec::new();
        let candidate = problem.candidates.iter().find(|own| {
            let [Bound::Node(node)] = own.bound[..] else { return false };
            let name = &problem.model.nodes[node].name;
            readings = (problem.measurements.iter())
                .flat_map(|measurement| {
                    let of = measurement.sensors.iter().position(|sensor| {
                        problem.model.quantities[sensor.quantity].name == *name || sensor.name == *name
                    });
                    let fitted = (0..measurement.len()).filter(|&row| !measurement.held_out(row));
                    fitted.filter_map(move |row| measurement.reading(row, of?))
                })
                .collect();
            own.effect == "missing-heater" && readings.len() > 3
        });
        let candidate = candidate.expect("a heater at a node with a sensor");
        let file = catalogue.get("missing-heater").unwrap();
        let parameters = file.parameters(&problem.model, &candidate.bound);
        let threshold = parameters.iter().find(|own| own.name == "threshold").unwrap();
        let least = readings.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = readings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is = |value: f64| is_crossed(&problem, candidate, file, threshold, value);
        let margin = reach * (greatest - least);
        assert!(is(0.5 * (least + greatest)), "{kind:?}: {least} to {greatest}");
        assert!(!is(greatest + margin + 0.01) && !is(least - margin - 0.01), "{kind:?}: {least} to {greatest}");
        assert!(reach == 0.0 || is(greatest + 0.9 * margin), "what melts acts before its level is reached");
    }
}
