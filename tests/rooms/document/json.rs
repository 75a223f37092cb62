//! Tests of `core/src/document/json.rs`.

use bmv::document::diagnostic::Diagnostics;
use bmv::document::json::*;
use bmv::document::source::Source;

fn read(text: &str) -> (Option<Node>, Vec<(String, Option<String>)>) {
    let mut diagnostics = Diagnostics::new();
    let node = parse(&Source::new("a.json", text), &mut diagnostics);
    (node, diagnostics.plain().into_iter().map(|plain| (plain.message, plain.help)).collect())
}

#[test]
fn a_long_key_is_kept_once_however_much_stands_under_it() {
    let text = format!(r#"{{"{}": [0, [1], {{"b": 2}}]}}"#, "k".repeat(1000));
    let (node, _) = read(&text);
    let Some(Node { value: Value::Object(entries), .. }) = node else { panic!("an object") };
    let Value::Array(items) = &entries[0].node.value else { panic!("an array") };
    let above = |item: &Node| item.place.path.parent().expect("not the root").clone();
    assert!(items.iter().all(|item| above(item).is_same(&entries[0].node.place.path)));
    assert!(entries[0].key_place.path.is_same(&entries[0].node.place.path));
    let Value::Object(inner) = &items[2].value else { panic!("an object") };
    assert!(above(&inner[0].node).is_same(&items[2].place.path));
    assert!(inner[0].node.place.path.to_string().ends_with("k[2].b"));
}

#[test]
#[ignore = "thorough"]
fn a_file_of_too_many_values_is_refused_at_the_first_beyond() {
    let fits = format!("[{}0]", "0,".repeat(VALUES - 2));
    assert!(read(&fits).1.is_empty());
    let (node, errors) = read(&format!("[{}0]", "0,".repeat(VALUES - 1)));
    assert!(node.is_none());
    assert_eq!(errors[0].0, "the file has more than 1000000 values");
}

#[test]
fn a_decimal_comma_is_answered_with_the_number_it_means() {
    let said = |text: &str| read(text).1;
    let one = |message: &str, help: &str| vec![(message.to_owned(), Some(help.to_owned()))];
    let errors = said(r#"{"a": 0,6, "b": 1}"#);
    assert_eq!(errors, one("`0,6` is no JSON number: it has a decimal comma", "write 0.6"));
    let errors = said(r#"{"a": -12,50e-3}"#);
    assert_eq!(errors, one("`-12,50e-3` is no JSON number: it has a decimal comma", "write -12.50e-3"));
    // In an array it may be two numbers.
    assert!(said(r#"{"a": [0,6]}"#).is_empty());
    assert!(said(r#"{"a": 0,"b": 6}"#).is_empty());
}
