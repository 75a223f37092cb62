//! Tests of `core/src/effect/catalogue.rs`.

use bmv::document::Diagnostics;
use bmv::effect::catalogue::*;

#[test]
fn every_file_is_listed_and_right() {
    let mut diagnostics = Diagnostics::new();
    let catalogue = Catalogue::embedded(&mut diagnostics);
    catalogue.check(&mut diagnostics);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(false, 10));
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/core/src/effect/catalogue");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder")
        .map(|file| file.expect("a file").file_name().to_string_lossy().trim_end_matches(".json").to_owned())
        .collect();
    files.sort();
    let mut names: Vec<&str> = catalogue.names().collect();
    names.sort_unstable();
    assert_eq!(files, names);
    for effect in catalogue.effects() {
        let form = &effect.form;
        for text in [&form.equation, &form.signature, &form.separate] {
            assert!(text.as_ref().is_some_and(|text| text.len() > 4), "{} is described", effect.name);
        }
        assert!(form.evidence.is_some() && form.source.len() > 10, "{} has a source", effect.name);
    }
}

#[test]
fn what_only_stores_heat_shows_in_no_steady_phase() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let stores = |name: &str, place: &str| catalogue.get(name).expect("an effect").only_stores(place);
    for (name, place) in [("thermal-mass", "node"), ("path-capacity", "conductor"), ("hidden-node", "node")] {
        assert!(stores(name, place), "{name}");
        assert!(!catalogue.get(name).expect("an effect").form.seen_by.contains(&bmv::effect::form::SeenBy::Steady));
    }
    // Between two nodes it leads heat; a drift changes what is read.
    for (name, place) in [("hidden-node", "nodes"), ("conductive-path", "nodes"), ("sensor-drift", "sensor")] {
        assert!(!stores(name, place), "{name}");
    }
}

/// What sets in at a date and what sets in at a time into every run look alike in a pass of few runs.
#[test]
fn changes_at_a_date_and_into_every_run_name_one_another() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let of = |clock| catalogue.effects().iter().filter(move |effect| effect.depends_on(clock));
    let names = |one: &bmv::effect::Effect, other: &bmv::effect::Effect| {
        one.form.confused_with.iter().any(|name| name.value == other.name)
    };
    let steps = ["load", "conductance", "bias"];
    for dated in
        of(bmv::thermal::Clock::Date).filter(|dated| steps.iter().any(|own| dated.name == format!("dated-{own}")))
    {
        assert!(of(bmv::thermal::Clock::Elapsed).any(|event| names(dated, event)), "{}", dated.name);
        for event in of(bmv::thermal::Clock::Elapsed) {
            assert_eq!(names(dated, event), names(event, dated), "{} and {}", dated.name, event.name);
        }
    }
}
