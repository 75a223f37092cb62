//! Tests of `src/batch/next_pass/text.rs`.

use bmv::batch::next_pass::text::*;
use bmv::document::{Diagnostics, Source, json};

#[test]
fn sections_are_broken_and_short_objects_are_not() {
    let written = r#"{"format":"x","jobs":{"tuned":{"calibrate":{"draws":3e3,"data":["a b"]}},"q\"":{}},"none":{},"kind":{"a":{"b":{"where":["aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa","bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"],"c":1}}},"long":["aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa","bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb", 1e-05, true, null]}"#;
    let mut diagnostics = Diagnostics::new();
    let node = json::parse(&Source::new("x", written), &mut diagnostics).expect("JSON");
    let text = Item::of_node(&node).document();
    insta::assert_snapshot!(text, @r#"
    {
      "format": "x",
      "jobs": {
        "tuned": {"calibrate": {"draws": 3e3, "data": ["a b"]}},
        "q\"": {}
      },
      "none": {},
      "kind": {
        "a": {"b": {
          "where": ["aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"],
          "c": 1
        }}
      },
      "long": [
        "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
        "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb",
        1e-05,
        true,
        null
      ]
    }
    "#);
    let again = json::parse(&Source::new("x", text), &mut diagnostics).expect("JSON");
    assert_eq!(again.to_json(), node.to_json());
}
