//! Tests of `core/src/document/declare.rs`.

use bmv::document::{Diagnostics, Map, Schemas, Source, Written, json};
use bmv_core::{written_choice, written_struct, written_words};

written_struct! {
    /// A thing
    /// of two lines.
    pub struct Thing: "a thing" {
        /// How many.
        required count: usize,
        /// Where.
        optional place as "where": String,
        /// Which.
        default(Colour::Red) colour: Colour,
        /// Of what.
        default(Map::default()) parts: Map<Shape>,
    }
}

written_choice! {
    /// A shape.
    pub enum Shape: "a shape" {
        /// By its radius.
        "round" => Round(f64),
        /// By its sides.
        "box" => Box([f64; 2]),
    }
}

written_words! {
    /// A colour.
    pub enum Colour: "a colour" {
        /// Red.
        "red" => Red,
        /// Light blue.
        "light-blue" => LightBlue,
    }
}

fn read(text: &str) -> (Option<Thing>, Vec<(String, String)>) {
    let mut diagnostics = Diagnostics::new();
    let node = json::parse(&Source::new("thing.json", text), &mut diagnostics).expect("JSON");
    let thing = Thing::read(&node, &mut diagnostics);
    (thing, diagnostics.plain().into_iter().map(|d| (d.code, d.path)).collect())
}

#[test]
fn a_declared_type_reads() {
    let (thing, reported) = read(
        r#"{"count": 2, "where": "here", "colour": "light-blue", "parts": {"b": {"box": [1, 2]}, "a": {"round": 3}}}"#,
    );
    let thing = thing.expect("valid");
    assert!(reported.is_empty());
    assert_eq!((thing.count, thing.place.as_deref(), thing.colour.word()), (2, Some("here"), "light-blue"));
    assert_eq!(thing.parts.names().collect::<Vec<_>>(), ["b", "a"], "the order of the file");
    assert_eq!(thing.parts.get("a").map(|e| (e.value.kind(), &e.value)), Some(("round", &Shape::Round(3.0))));
    let (least, _) = read(r#"{"count": 0, "where": null}"#);
    assert_eq!(least.map(|t| (t.place, t.colour)), Some((None, Colour::Red)));
}

#[test]
fn all_errors_are_found() {
    let (thing, reported) =
        read(r#"{"cuont": 2, "where": 3, "colour": "rde", "parts": {"a": {"round": "x"}, "b": {}, "c": {"bxo": 1}}}"#);
    assert!(thing.is_none());
    let expected = [
        ("missing-field", "$"),
        ("unknown-field", "$.cuont"),
        ("wrong-type", "$.where"),
        ("unknown-kind", "$.colour"),
        ("wrong-type", "$.parts.a.round"),
        ("one-kind", "$.parts.b"),
        ("unknown-kind", "$.parts.c.bxo"),
    ];
    let reported: Vec<(&str, &str)> = reported.iter().map(|(c, p)| (c.as_str(), p.as_str())).collect();
    assert_eq!(reported, expected);
}

#[test]
fn the_schema_says_the_same() {
    let schema = Schemas::document::<Thing>("things");
    let thing = &schema["$defs"]["Thing"];
    assert_eq!(schema["$ref"], "#/$defs/Thing");
    assert_eq!(thing["required"], serde_json::json!(["count"]));
    assert_eq!(thing["description"], "A thing of two lines.");
    assert_eq!(thing["properties"]["where"]["description"], "Where.");
    assert_eq!(schema["$defs"]["Colour"]["oneOf"][1]["const"], "light-blue");
    assert_eq!(schema["$defs"]["Shape"]["oneOf"][0]["required"][0], "round");
}

#[test]
fn a_choice_that_is_no_object_or_has_strangers_is_mended_by_its_help() {
    let help = |text: &str| {
        let mut diagnostics = Diagnostics::new();
        let node = json::parse(&Source::new("shape.json", text), &mut diagnostics).expect("JSON");
        assert!(Shape::read(&node, &mut diagnostics).is_none());
        let reported = diagnostics.plain().into_iter().next().expect("one error");
        (reported.code, reported.help.unwrap_or_default())
    };
    let of = |code: &str, help: &str| (code.to_owned(), help.to_owned());
    assert_eq!(help(r#""round""#), of("one-kind", r#"the kind is a key: {"round": ...}"#));
    assert_eq!(
        help(r#"{"round": 1, "colour": "red", "weight": 2}"#),
        of("one-kind", "leave out `colour` and `weight`")
    );
    let strangers = help(r#"{"round": {}, "colour": "red"}"#);
    assert_eq!(strangers, of("one-kind", "move `colour` into `round`, or leave out what does not belong there"));
    assert_eq!(help(r#""oval""#).0, "wrong-type");
}
