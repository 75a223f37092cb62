//! Tests of `src/study/changed.rs`.

use bmv::document::source::Source;
use bmv::document::{Diagnostics, json};
use bmv::study::changed::*;

fn changes(before: &str, after: &str) -> Vec<String> {
    let mut diagnostics = Diagnostics::new();
    let mut tree = |name: &str, text: &str| json::parse(&Source::new(name, text), &mut diagnostics).expect("JSON");
    let (before, after) = (tree("a.json", before), tree("b.json", after));
    let mut changed_entries = Vec::new();
    walk("", Some(&without_words(before)), Some(&without_words(after)), &mut changed_entries);
    let text = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    changed_entries
        .into_iter()
        .map(|one| format!("{} {}: {} | {}", one.at, one.entry, text(one.before), text(one.after)))
        .collect()
}

#[test]
fn entries_are_named_where_they_stand_and_values_read_as_written() {
    let before = r#"{"title": "a", "parameters": {"G": {"prior": {"uniform": [0.15, 5e-1]}}, "e": {"nominal": 2}},
        "measurements": {"test": {"sigma": {"value": 0.1, "unit": "K"}, "rows": [{"at": 1}, {"at": 2}]}}}"#;
    let after = r#"{"title": "b", "parameters": {"G": {"prior": {"normal": [0.3, 0.1]}}, "e": {"nominal": 2.0}},
        "measurements": {"test": {"sigma": {"value": 0.2, "unit": "K"}, "rows": [{"at": 1}, {"at": 3}]}},
        "adopt": {"more": {"where": "plate"}}}"#;
    assert_eq!(
        changes(before, after),
        [
            "b.json:1 parameters.G.prior: uniform [0.15,0.5] | normal [0.3,0.1]",
            "b.json:2 measurements.test.sigma: 0.1 K | 0.2 K",
            "b.json:2 measurements.test.rows[1].at: 2 | 3",
            "b.json:3 adopt.more: - | where plate",
        ]
    );
    assert_eq!(changes(after, after), Vec::<String>::new());
    let gone = changes(after, "{}");
    assert_eq!(gone[0], "a.json:1 parameters.G: prior normal [0.3,0.1] | -", "what is gone stands where it was");
    assert_eq!(gone.len(), 4);
    assert_eq!(changes(r#"{"seed": 1}"#, r#"{"seed": 1e0}"#), Vec::<String>::new(), "the same number");
}
