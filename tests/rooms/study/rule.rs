//! Tests of `src/study/rule.rs`.

use bmv::document::Diagnostics;
use bmv::study::folder::Folder;
use bmv::study::rule::*;

#[test]
fn the_programs_own_rules_are_complete() {
    let mut diagnostics = Diagnostics::new();
    let rules = load(None, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(false, 10));
    let margins: Vec<_> = rules.iter().map(|(rule, _)| (rule.name.as_str(), rule.margin)).collect();
    assert_eq!(
        margins,
        [
            ("none", Margin::TemperatureK(0.0)),
            ("nasa-gsfc-5k", Margin::TemperatureK(5.0)),
            ("military-11k", Margin::TemperatureK(11.0)),
            ("military-17k", Margin::TemperatureK(17.0)),
            ("heat-load-25", Margin::HeatLoad(0.25)),
        ]
    );
    assert!(rules[1].0.source.contains("could not be opened"));
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src/study/rules")).expect("the folder");
    assert_eq!(files.count(), EMBEDDED.len(), "every file is in the list");
}

#[test]
fn a_study_adds_and_replaces_rules() {
    let root = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(root.path().join("rules")).expect("made");
    let rule = r#"{"format": "bmv-rule/1", "title": "ours", "margin": {"temperature": 7}, "source": "house rule"}"#;
    std::fs::write(root.path().join("rules/ours.json"), rule).expect("written");
    std::fs::write(root.path().join("rules/military-11k.json"), rule).expect("written");
    let wrong = rule.replace("7", "-7");
    std::fs::write(root.path().join("rules/wrong.json"), wrong).expect("written");
    let mut diagnostics = Diagnostics::new();
    let rules = load(Some(&Folder::open(root.path()).expect("opened")), &mut diagnostics);
    let names: Vec<_> = rules.iter().map(|(rule, _)| rule.name.as_str()).collect();
    assert_eq!(names, ["none", "nasa-gsfc-5k", "military-17k", "heat-load-25", "military-11k", "ours"]);
    assert_eq!(rules[4].0.margin, Margin::TemperatureK(7.0));
    assert_eq!(diagnostics.plain()[0].message, "a margin of -7 is negative");
}
