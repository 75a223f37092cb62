//! Tests of `core/src/document/code/mod.rs`.

use std::collections::BTreeSet;

#[test]
fn codes_are_unique_and_explained() {
    let mut names = BTreeSet::new();
    for code in bmv::document::code::all() {
        assert!(names.insert(code.name), "{} stands twice", code.name);
        assert!(code.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'), "{}", code.name);
        assert!(code.explanation.len() > 80, "{} is explained at length", code.name);
        assert!(!code.example.is_empty() && !code.title.is_empty(), "{} has an example", code.name);
        assert_eq!(bmv::document::code::find(code.name), Some(code));
    }
    assert!(names.len() > 40, "{}", names.len());
}
