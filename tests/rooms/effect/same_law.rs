//! Tests of `core/src/effect/same_law.rs`.

use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Chosen, candidates, candidates_at};
use bmv::thermal::{Limits, Model, Node, NodeKind};

#[test]
fn a_studys_own_law_stands_in_the_place_of_the_programs() {
    let mut diagnostics = Diagnostics::new();
    let mut catalogue = Catalogue::embedded(&mut diagnostics);
    let own = r#"{"format": "bmv-effect/1", "title": "Spreading", "applies": {"sensor": {}},
        "inputs": {"heat": {"unit": "W", "description": "heat"}},
        "parameters": {"resistance": {"unit": "K/W", "prior": {"halfnormal": 0.3}, "sign": "positive", "plausible": 0.3}},
        "adds": {"reading": "T + resistance * heat"}, "source": "a plate"}"#;
    catalogue.read("spreading", "spreading.json", own.as_bytes(), &mut diagnostics).expect("read");
    let effect = |name: &str| catalogue.get(name).expect("there");
    assert!(effect("spreading").is_same_law(effect("sensor-gradient")));
    assert!(!effect("spreading").is_same_law(effect("sensor-self-heating")), "no input");
    assert!(!effect("input-proportional-load").is_same_law(effect("joule-heating")), "its square");
    assert!(!effect("spreading").is_same_law(effect("input-proportional-load")), "heat, not a reading");
}

/// A law of temperature whose own reference is 20 degC.
#[test]
fn a_reference_temperature_that_is_written_out_is_that_of_what_states_none() {
    let mut diagnostics = Diagnostics::new();
    let mut catalogue = Catalogue::embedded(&mut diagnostics);
    let own = |reference: f64| {
        format!(
            r#"{{"format": "bmv-effect/1", "title": "Own", "applies": {{"conductor": {{}}}},
            "parameters": {{"b": {{"unit": "1/K", "prior": {{"normal": {{"mean": 0, "sd": 0.01}}}}}}}},
            "adds": {{"factor": "1 + b * (Tm - {reference})"}}, "source": "a data sheet"}}"#
        )
    };
    for (name, reference) in [("at-20-degc", 293.15), ("at-0-degc", 273.15)] {
        catalogue.read(name, "own.json", own(reference).as_bytes(), &mut diagnostics).expect("read");
    }
    let effect = |name: &str| catalogue.get(name).expect("there");
    let law = effect("temperature-dependent-conductance");
    assert!(effect("at-20-degc").is_same_law(law) && !effect("at-0-degc").is_same_law(law));
    assert!(law.has_reference() && !effect("at-20-degc").has_reference());
}

#[test]
fn heat_in_proportion_to_one_input_is_known_by_its_law() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let proportional: Vec<&str> =
        catalogue.effects().iter().filter(|own| own.is_proportional_load()).map(|own| own.name.as_str()).collect();
    assert_eq!(proportional, ["input-proportional-load"]);
}

/// A study's effect of this law beside those of the program.
fn with_own(adds: &str) -> Catalogue {
    let mut diagnostics = Diagnostics::new();
    let mut catalogue = Catalogue::embedded(&mut diagnostics);
    let own = format!(
        r#"{{"format": "bmv-effect/1", "title": "Heat of the battery", "applies": {{"node": {{}}}},
        "parameters": {{"heat": {{"unit": "W", "prior": {{"normal": {{"mean": 0, "sd": 3}}}}, "plausible": 3}}}},
        "adds": {{"load": "{adds}"}}, "source": "a data sheet"}}"#
    );
    catalogue.read("battery", "battery.json", own.as_bytes(), &mut diagnostics).expect("read");
    catalogue
}

#[test]
fn so_it_does_at_chosen_places_of_a_large_model() {
    let mut model = Model::default();
    let capacity = model.graph.number(900.0);
    let kind = NodeKind::Diffusion { capacity };
    model.nodes = vec![Node { name: "box".into(), kind, area: None, alias: None, limits: Limits::default() }];
    let loads = |catalogue: &Catalogue, wanted: &dyn Fn(&str) -> bool| -> Vec<String> {
        let at = candidates_at(&model, &[], catalogue, &[Chosen::Node(0)], wanted);
        let all = at.into_iter().filter(|own| ["heat-load", "battery"].contains(&own.effect.as_str()));
        all.map(|own| own.id).collect()
    };
    let same = with_own("heat");
    assert_eq!(loads(&same, &|_| true), ["battery:box"]);
    assert_eq!(loads(&same, &|effect| effect == "heat-load"), ["heat-load:box"], "where the other is not asked for");
    assert_eq!(loads(&with_own("2 * heat"), &|_| true), ["heat-load:box", "battery:box"], "another law");
    // A small model has the same.
    let small = candidates(&model, &[], &[], &same);
    assert!(small.iter().any(|own| own.id == "battery:box") && !small.iter().any(|own| own.id == "heat-load:box"));
}
