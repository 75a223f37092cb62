//! Tests of `core/src/effect/candidate.rs`.

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::effect::candidate::*;
use bmv::effect::place::Site;

fn on(where_kind: &'static str, effect: &str, elements: &[usize]) -> Candidate {
    Candidate {
        id: String::new(),
        effect: effect.to_owned(),
        where_kind,
        place: Vec::new(),
        input: None,
        site: Site::Elements(elements.into()),
        bound: Vec::new(),
        steady: true,
        transient: true,
    }
}

#[test]
fn a_group_is_the_whole_of_its_members_with_the_same_effect() {
    let wall = on(GROUP, "input-dependent-conductance", &[2, 3, 4]);
    assert!(wall.is_whole_of(&on("conductor", "input-dependent-conductance", &[3])));
    assert!(!wall.is_whole_of(&on("conductor", "input-dependent-conductance", &[5])));
    assert!(!wall.is_whole_of(&on("conductor", "conductance-step", &[3])));
    assert!(!wall.is_whole_of(&wall), "a group is no part of itself");
    // By another law a group goes before a member all the same; sensors have no such surface.
    assert!(wall.goes_before_member(&on("conductor", "conductance-step", &[3])));
    assert!(!wall.goes_before_member(&on("conductor", "conductance-step", &[5])) && !wall.goes_before_member(&wall));
    assert!(!on("conductor", "conductance-step", &[3, 4]).is_whole_of(&on("conductor", "conductance-step", &[3])));
}

#[test]
fn a_group_goes_before_places_of_its_own_kind_only_where_they_are_members() {
    let wall = on(GROUP, "heat-load", &[2, 3, 4]);
    assert!(wall.is_elsewhere_than(&on("conductor", "heat-load", &[5])));
    assert!(!wall.is_elsewhere_than(&on("conductor", "heat-load", &[3])));
    let node = Candidate { site: Site::Nodes([(5, 1.0)].into()), ..on("node", "heat-load", &[]) };
    assert!(!wall.is_elsewhere_than(&node), "no element is compared with a node");
    assert!(!on("conductor", "heat-load", &[2]).is_elsewhere_than(&on("conductor", "heat-load", &[5])));
}

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
