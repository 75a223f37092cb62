//! Tests of `core/src/effect/thermometers.rs`.

use std::sync::Arc;

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::sensor_places;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

/// A reading of one thermometer ahead of the inputs is that thermometer's fault; of all of them it may be that of the inputs.
#[test]
fn a_clock_behind_at_all_thermometers_is_titled_beside_that_of_the_inputs() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steps, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).expect("a case").problem;
    let sensors = sensor_places(problem.measurements.iter());
    let clock = catalogue.get("sensor-clock").expect("there");
    let (mut of_one, mut of_all) = (0, 0);
    for candidate in problem.candidates.iter().filter(|candidate| candidate.effect == "sensor-clock") {
        let title = clock.title_at(candidate, &problem.model, &sensors);
        match candidate.id == "sensor-clock:all thermometers" {
            true => {
                of_all += 1;
                assert!(title.starts_with("Readings of all thermometers offset in time from the inputs"), "{title}");
            }
            false => {
                of_one += 1;
                assert!(title.starts_with("Readings offset in time"), "{title}");
            }
        }
    }
    assert!(of_one > 1 && of_all == 1, "{of_one} and {of_all}");
}
