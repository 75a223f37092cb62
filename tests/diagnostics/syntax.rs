//! JSON that is none, or of the wrong shape.

use super::rendered;

#[test]
fn empty_file() {
    let text = r#""#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: the file is empty
     --> model.json:1:1
      |
    1 |
      | ^
      |
      = note: at $
      = help: a file of bmv is one JSON object: {"format": ...}
    "#);
}

#[test]
fn file_broken_off() {
    let text = r#"{"format": "bmv-network/1", "nodes": {"plate": {}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-end]: the file ends where `,` or `}` is expected
     --> model.json:1:50
      |
    1 | {"format": "bmv-network/1", "nodes": {"plate": {}
      |                                                  ^
      |
      = note: at $.nodes
      = help: a bracket, brace or quote is not closed
    "#);
}

#[test]
fn missing_comma() {
    let text = r#"{"format": "bmv-network/1"
 "title": "bench"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: expected `,` or `}`
     --> model.json:2:2
      |
    2 |  "title": "bench"}
      |  ^
      |
      = note: at $
      = help: separate entries with a comma
    "#);
}

#[test]
fn trailing_comma() {
    let text = r#"{"format": "bmv-network/1", "nodes": {},}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-trailing-comma]: a comma before the closing `}`
     --> model.json:1:40
      |
    1 | {"format": "bmv-network/1", "nodes": {},}
      |                                        ^
      |
      = note: at $
      = help: remove the comma
    "#);
}

#[test]
fn comment() {
    let text = r#"{"format": "bmv-network/1", // the bench
 "title": "bench"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-comment]: JSON has no comments
     --> model.json:1:29
      |
    1 | {"format": "bmv-network/1", // the bench
      |                             ^^^^^^^^^^^^
      |
      = note: at $
      = help: put the remark into a "description" or "because" field
    "#);
}

#[test]
fn duplicate_key() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": 290},
  "plate": {"capacity": 700}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[duplicate-key]: the key "plate" stands twice in this object
     --> model.json:5:3
      |
    5 |   "plate": {"capacity": 700}},
      |   ^^^^^^^
      |
     ::: model.json:4:12
      |
    4 |  "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": 290},
      |            ------- first here
      |
      = note: at $.nodes.plate
      = help: rename or remove one of them (the other is on line 4)
    "#);
}

#[test]
fn invalid_escape() {
    let text = r#"{"format": "bmv-network/1", "title": "C:\data"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-escape]: `\d` is no escape of JSON
     --> model.json:1:41
      |
    1 | {"format": "bmv-network/1", "title": "C:\data"}
      |                                         ^^
      |
      = note: at $.title
      = help: valid are \" \\ \/ \b \f \n \r \t and \u with four hexadecimal digits; a backslash itself is \\
    "#);
}

#[test]
fn lone_surrogate() {
    let text = r#"{"format": "bmv-network/1", "title": "\ud83d"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-escape]: `\ud83d` is half of a character
     --> model.json:1:39
      |
    1 | {"format": "bmv-network/1", "title": "\ud83d"}
      |                                       ^^^^^^
      |
      = note: at $.title
      = help: valid are \" \\ \/ \b \f \n \r \t and \u with four hexadecimal digits; a backslash itself is \\
    "#);
}

#[test]
fn line_break_in_string() {
    let text = r#"{"format": "bmv-network/1", "title": "bench
}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-control-character]: the string is not closed on its line
     --> model.json:1:38
      |
    1 | {"format": "bmv-network/1", "title": "bench
      |                                      ^^^^^^
      |
      = note: at $.title
      = help: close it with ", or write \n for a line break
    "#);
}

#[test]
fn not_a_number() {
    let text = r#"{"format": "bmv-network/1", "nodes": {"plate": {"capacity": NaN}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-nan]: JSON has no `NaN`
     --> model.json:1:61
      |
    1 | {"format": "bmv-network/1", "nodes": {"plate": {"capacity": NaN}}}
      |                                                             ^^^
      |
      = note: at $.nodes.plate.capacity
      = help: write a finite number, or leave the field out
    "#);
}

#[test]
fn number_too_large() {
    let text = r#"{"format": "bmv-network/1", "nodes": {"plate": {"capacity": 1e400}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-number-range]: the number `1e400` is too large
     --> model.json:1:61
      |
    1 | {"format": "bmv-network/1", "nodes": {"plate": {"capacity": 1e400}}}
      |                                                             ^^^^^
      |
      = note: at $.nodes.plate.capacity
      = help: the largest is about 1.8e308
    "#);
}

#[test]
fn number_without_digit() {
    let text = r#"{"format": "bmv-network/1", "nodes": {"plate": {"capacity": .5}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-number]: `.5` is no JSON number: a digit is missing before the point
     --> model.json:1:61
      |
    1 | {"format": "bmv-network/1", "nodes": {"plate": {"capacity": .5}}}
      |                                                             ^^
      |
      = note: at $.nodes.plate.capacity
      = help: numbers look like 12, -0.5 or 1.2e-3
    "#);
}

#[test]
fn single_quotes() {
    let text = r#"{"format": 'bmv-network/1'}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: a string stands in double quotes
     --> model.json:1:12
      |
    1 | {"format": 'bmv-network/1'}
      |            ^^^^^^^^^^^^^^^
      |
      = note: at $.format
      = help: replace ' by "
    "#);
}

#[test]
fn byte_order_mark() {
    let text = "\u{feff}{\"format\": \"bmv-network/1\", \"quantities\": {}}";
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-bom]: the file begins with a byte order mark
     --> model.json:1:1
      |
    1 | �{"format": "bmv-network/1", "quantities": {}}
      | ^
      |
      = note: at $
      = help: save it as UTF-8 without BOM
    "#);
}

#[test]
fn text_behind() {
    let text = r#"{"format": "bmv-network/1"} {}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: text after the end of the document
     --> model.json:1:29
      |
    1 | {"format": "bmv-network/1"} {}
      |                             ^
      |
      = note: at $
      = help: a file holds one JSON value; remove what follows
    "#);
}

#[test]
fn wrong_bracket() {
    let text = r#"{"format": "bmv-network/1", "nodes": {"plate": {]}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: expected a key, found ']'
     --> model.json:1:49
      |
    1 | {"format": "bmv-network/1", "nodes": {"plate": {]}}
      |                                                 ^
      |
      = note: at $.nodes.plate
      = help: a field is "name": value
    "#);
}

#[test]
fn several_errors_at_once() {
    let text = r#"{"format": "bmv-network/1", "title": True, "nodes": {"plate": {"capacity": 01, "area": +2}},}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[json-syntax]: `True` is no JSON value
     --> model.json:1:38
      |
    1 | {"format": "bmv-network/1", "title": True, "nodes": {"plate": {"capacity": 01, "area": +2}},}
      |                                      ^^^^
      |
      = note: at $.title
      = help: write true, or "True" for a string

    error[json-number]: `01` is no JSON number: it begins with a zero
     --> model.json:1:76
      |
    1 | {"format": "bmv-network/1", "title": True, "nodes": {"plate": {"capacity": 01, "area": +2}},}
      |                                                                            ^^
      |
      = note: at $.nodes.plate.capacity
      = help: numbers look like 12, -0.5 or 1.2e-3

    error[json-number]: `+2` is no JSON number: it begins with `+`
     --> model.json:1:88
      |
    1 | {"format": "bmv-network/1", "title": True, "nodes": {"plate": {"capacity": 01, "area": +2}},}
      |                                                                                        ^^
      |
      = note: at $.nodes.plate.area
      = help: numbers look like 12, -0.5 or 1.2e-3

    error[json-trailing-comma]: a comma before the closing `}`
     --> model.json:1:92
      |
    1 | {"format": "bmv-network/1", "title": True, "nodes": {"plate": {"capacity": 01, "area": +2}},}
      |                                                                                            ^
      |
      = note: at $
      = help: remove the comma
    "#);
}

#[test]
fn unknown_format() {
    let text = r#"{"format": "bmv-network/9"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[format-version]: unknown format `bmv-network/9`
     --> model.json:1:12
      |
    1 | {"format": "bmv-network/9"}
      |            ^^^^^^^^^^^^^^^ `bmv-network/1`
      |
      = note: at $.format
    "#);
}

#[test]
fn another_files_format() {
    let text = r#"{"format": "bmv-pass/1"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[format-version]: this is a file of format `bmv-pass/1`
     --> model.json:1:12
      |
    1 | {"format": "bmv-pass/1"}
      |            ^^^^^^^^^^^^ `bmv-network/1`
      |
      = note: at $.format
    "#);
}

#[test]
fn format_missing() {
    let text = r#"{"title": "bench"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[missing-field]: missing field `format`
     --> model.json:1:1
      |
    1 | {"title": "bench"}
      | ^ "format": "bmv-network/1"
      |
      = note: at $
    "#);
}

#[test]
fn not_an_object() {
    let text = r#"[1, 2]"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[wrong-type]: an array cannot stand here
     --> model.json:1:1
      |
    1 | [1, 2]
      | ^^^^^^ an object
      |
      = note: at $
    "#);
}
