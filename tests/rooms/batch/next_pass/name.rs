//! Tests of `src/batch/next_pass/name.rs`.

use bmv::batch::next_pass::name::*;

fn named(effect: &str, place: &[&str], where_kind: &str, input: Option<&str>, used: &[&str]) -> String {
    let place: Vec<String> = place.iter().map(|&name| name.to_owned()).collect();
    name(effect, &place, where_kind, input, &|name| used.contains(&name))
}

#[test]
fn names_say_where_and_what_and_are_free() {
    let path = |used: &[&str]| named("conductive-path", &["baseplate", "board"], "nodes", None, used);
    assert_eq!(path(&[]), "baseplate-board conductive path");
    assert_eq!(named("sensor-bias", &["TC box"], "sensor", None, &[]), "TC box bias");
    assert_eq!(named("joule-heating", &["box"], "node", Some("i"), &[]), "box joule heating (i)");
    let repeated = named("dissipation-temperature", &["dissipation"], "element", None, &[]);
    assert_eq!(repeated, "dissipation temperature dependence");
    let used = ["baseplate-board conductive path", "baseplate-board conductive path 2"];
    assert_eq!(path(&used), "baseplate-board conductive path 3");
    assert_eq!(named("heat-load", &[&"n".repeat(100)], "node", None, &[]), "heat load");
}
