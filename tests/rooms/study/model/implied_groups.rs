//! Tests of `src/study/model/implied_groups.rs`.

use bmv::document::Diagnostics;
use bmv::study::model::{Members, load};

/// Name, members by name and weights.
fn groups(text: &str) -> Vec<(String, Vec<(String, f64)>)> {
    let mut diagnostics = Diagnostics::new();
    let model = load("model.json", text.as_bytes(), &mut diagnostics).expect("a sound model");
    let node = |index: usize| model.model.nodes[index].name.clone();
    let element = |index: &usize| (model.model.elements[*index].name.clone(), 1.0);
    let members = |members: &Members| match members {
        Members::Nodes(nodes) => nodes.iter().map(|(index, weight)| (node(*index), *weight)).collect(),
        Members::Conductors(own) | Members::Radiations(own) | Members::Loads(own) => own.iter().map(element).collect(),
        Members::Sensors(_) => Vec::new(),
    };
    model.groups.iter().map(|group| (group.name.clone(), members(&group.members))).collect()
}

const PANELS: &str = r#"{"format": "bmv-network/1",
    "parameters": {"eps": {"nominal": 0.8}, "c": {"nominal": 100, "unit": "J/K"}, "G": {"nominal": 0.2, "unit": "W/K"}},
    "nodes": {"space": {"boundary": "3"}, "wide": {"capacity": "2*c"}, "narrow": {"capacity": "c"}, "box": {"capacity": "c"}},
    "radiations": {"view wide": {"between": ["wide", "space"], "exchange_area": "0.03*eps"},
                   "view narrow": {"between": ["space", "narrow"], "exchange_area": "0.01*eps"}},
    "conductors": {"mount": {"between": ["wide", "box"], "conductance": "G"}}GROUPS}"#;

#[test]
fn surfaces_materials_and_joints_that_share_a_parameter_are_groups() {
    let of = |name: &str, weight: f64| (name.to_owned(), weight);
    let found = groups(&PANELS.replace("GROUPS", ""));
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["nodes with eps to space", "nodes with c", "radiations with eps"]);
    assert_eq!(found[0].1, [of("wide", 0.75), of("narrow", 0.25)]);
    assert_eq!(found[1].1, [of("wide", 0.5), of("narrow", 0.25), of("box", 0.25)]);
    assert_eq!(found[2].1.len(), 2);
}

#[test]
fn what_the_file_groups_is_not_grouped_again() {
    let written = r#", "groups": {"panels": {"nodes": {"narrow": 1, "wide": 1}}}"#;
    let found = groups(&PANELS.replace("GROUPS", written));
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["panels", "nodes with c", "radiations with eps"]);
}

#[test]
fn loads_that_share_a_parameter_or_an_input_are_groups() {
    let loads = r#", "inputs": {"sun": {"nominal": 1361, "unit": "W/m2"}, "bus": {"nominal": 28, "unit": "V"}},
        "loads": {"on wide": {"into": "wide", "power": "0.02*sun"}, "on narrow": {"into": "narrow", "power": "0.01*sun"},
                  "own": {"into": "box", "power": "0.1*bus"}, "spread": {"into": "wide", "power": "G"},
                  "rest": {"into": "box", "power": "2*G"}}"#;
    let found = groups(&PANELS.replace("GROUPS", loads));
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    let of_loads = ["loads with G", "loads with sun"];
    assert_eq!(names[..3], ["nodes with eps to space", "nodes with c", "radiations with eps"]);
    assert_eq!(names[3..], of_loads, "{names:?}");
    let members = |name: &str| -> Vec<&str> {
        let group = found.iter().find(|(own, _)| own == name).expect("a group");
        group.1.iter().map(|(member, _)| member.as_str()).collect()
    };
    assert_eq!(members("loads with sun"), ["on wide", "on narrow"]);
    assert_eq!(members("loads with G"), ["spread", "rest"]);
}
