//! Tests of `src/study/inherit.rs`.

use bmv::document::diagnostic::Diagnostics;
use bmv::study::folder::Folder;
use bmv::study::inherit::*;
use bmv::study::reader::Reader;

fn study(files: &[(&str, &str)]) -> (tempfile::TempDir, Folder) {
    let root = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(root.path().join(name), text).expect("written");
    }
    let folder = Folder::open(root.path()).expect("opened");
    (root, folder)
}

fn merged(files: &[(&str, &str)], name: &str) -> (serde_json::Value, Vec<String>) {
    let (_root, folder) = study(files);
    let mut diagnostics = Diagnostics::new();
    let lineage = lineage(&Reader::new(bmv::study::job::Kinds::default()), &folder, name, &mut diagnostics)
        .expect("a file")
        .expect("a tree");
    let messages = diagnostics.plain().into_iter().map(|plain| plain.message).collect();
    (lineage.merged.to_json(), messages)
}

#[test]
fn named_entries_replace_remove_and_stay() {
    let (tree, messages) = merged(
        &[
            (
                "pass-1.json",
                r#"{"parent": null, "title": "one", "seed": 7, "parameters": {"a": {"x": 1, "y": 2}, "b": {"x": 1}, "c": {}}, "jobs": {"old": {}}}"#,
            ),
            ("pass-2.json", r#"{"parent": "pass-1.json", "parameters": {"a": {"x": 5}}, "environments": {"hot": {}}}"#),
            (
                "pass-3.json",
                r#"{"parent": "./pass-2.json", "title": "three", "parameters": {"b": null, "d": {}}, "jobs": {"new": {}}}"#,
            ),
        ],
        "pass-3.json",
    );
    assert_eq!(messages, [""; 0]);
    let expected = serde_json::json!({
        "parent": "./pass-2.json", "title": "three", "parameters": {"a": {"x": 5}, "c": {}, "d": {}},
        "jobs": {"new": {}}, "environments": {"hot": {}}, "seed": 7
    });
    assert_eq!(tree, expected);
}

#[test]
fn a_chain_of_parents_has_an_end() {
    let files: Vec<(String, String)> = (0..=MOST_PARENTS + 1)
        .map(|index| {
            let parent = if index == 0 { "null".to_owned() } else { format!("\"p{}.json\"", index - 1) };
            (format!("p{index}.json"), format!("{{\"parent\": {parent}, \"seed\": {index}}}"))
        })
        .collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let (_, messages) = merged(&files, &format!("p{MOST_PARENTS}.json"));
    assert_eq!(messages, [""; 0]);
    let (_, messages) = merged(&files, &format!("p{}.json", MOST_PARENTS + 1));
    assert_eq!(messages, ["`p101.json` has more than 100 parents, one behind the other"]);
}

#[test]
fn circles_are_refused() {
    let (_, messages) =
        merged(&[("a.json", r#"{"parent": "b.json"}"#), ("b.json", r#"{"parent": "./a.json"}"#)], "a.json");
    assert_eq!(messages, ["the parents run in a circle: a.json -> b.json -> a.json"]);
    let (_, messages) = merged(&[("a.json", r#"{"parent": "a.json"}"#)], "a.json");
    assert_eq!(messages, ["the parents run in a circle: a.json -> a.json"]);
}

#[test]
fn missing_parents_escapes_and_empty_removals_are_reported() {
    let (_, messages) = merged(&[("a.json", r#"{"parent": "b.json"}"#)], "a.json");
    assert_eq!(messages, ["the file `b.json` does not exist in the study's folder"]);
    let (_, messages) = merged(&[("a.json", r#"{"parent": "../b.json"}"#)], "a.json");
    assert!(messages[0].contains("leaves the study's folder"), "{messages:?}");
    let (tree, messages) = merged(&[("a.json", r#"{"parent": null, "adopt": {"x": null}}"#)], "a.json");
    assert_eq!(messages, ["no parent has `x` under `adopt`"]);
    assert_eq!(tree["adopt"], serde_json::json!({}));
}
