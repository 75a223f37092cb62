//! Tests of `diagnosis/src/diagnosis/verdict/surroundings.rs`.

use std::collections::BTreeMap;
use std::sync::Arc;

use bmv::diagnosis::output::Amount;
use bmv::diagnosis::verdict::surroundings::hint;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

/// What is said of a path whose surroundings are fitted at a temperature, K, where every logged temperature was 290 K.
/// Its unit is the catalogue's.
fn said(temperature_k: f64, sd: f64) -> Option<String> {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let temperatures: Vec<bool> = problem.model.inputs.iter().map(|input| input.unit == "K").collect();
    assert!(temperatures.contains(&true));
    for measurement in &mut problem.measurements {
        let Rows::Steady(phases) = &mut measurement.rows else { panic!("steady phases") };
        for phase in phases {
            for (value, is_temperature) in phase.inputs.iter_mut().zip(&temperatures) {
                *value = if *is_temperature { 290.0 } else { *value };
            }
        }
    }
    let path = problem.candidates.iter().find(|own| own.effect == "path-to-ambient").unwrap();
    let fitted = Amount {
        value: temperature_k - 273.15,
        sd,
        most_probable: temperature_k - 273.15,
        unit: "degC".to_owned(),
        at_bound: false,
        level: None,
    };
    hint(&problem, path, &BTreeMap::from([("temperature".to_owned(), fitted)]))
}

#[test]
fn surroundings_beside_the_logged_air_are_remarked() {
    let words = said(300.0, 2.0).unwrap();
    assert!(words.contains("26.9 degC") && words.contains("was 16.9 to 16.9 degC"), "{words}");
    // Within what the fit or the air's thermometer leaves open, or far from anything that was logged.
    assert_eq!([said(300.0, 11.0), said(292.0, 0.1), said(340.0, 2.0)], [None, None, None]);
}
