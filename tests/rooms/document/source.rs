//! Tests of `core/src/document/source.rs`.

use bmv::document::source::*;

#[test]
fn positions_count_characters_from_one() {
    let source = Source::new("a.json", "{\n \"Ω\": 1}");
    assert_eq!(source.position(0), Position { line: 1, column: 1 });
    let one = source.text().find('1').expect("there");
    assert_eq!(source.position(one), Position { line: 2, column: 7 });
    assert_eq!(source.position(999), Position { line: 2, column: 9 });
}

#[test]
fn places_inside_strings_allow_for_escapes() {
    let source = Source::new("a.json", r#""G\u00e9 + \"x""#);
    let place = Place { source: source.clone(), span: Span::new(0, source.text().len()), path: JsonPath::root() };
    // Decoded: `Gé + "x`, where x is byte 7.
    assert_eq!(place.inside_string(7, 8).text(), "x");
    assert_eq!(place.inside_string(1, 3).text(), r"\u00e9");
    assert_eq!(place.inside_string(0, 1).text(), "G");
}

#[test]
fn paths_show_plain_keys_bare_and_others_quoted() {
    let path = JsonPath::root().key("nodes").key("a \"b\"").index(3);
    assert_eq!(path.to_string(), r#"$.nodes["a \"b\""][3]"#);
    assert_eq!(JsonPath::default().to_string(), "");
    assert!(JsonPath::default().is_empty() && !path.is_empty());
}
