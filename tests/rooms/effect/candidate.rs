//! Tests of `core/src/effect/candidate.rs`.

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
    let thermometers = Candidate { site: Site::Sensors(Vec::new()), ..on(GROUP, "sensor-lag", &[]) };
    assert!(
        thermometers.is_elsewhere_than(&node) && wall.is_elsewhere_than(&thermometers),
        "a node is no part of them"
    );
    assert!(!on("conductor", "heat-load", &[2]).is_elsewhere_than(&on("conductor", "heat-load", &[5])));
}
