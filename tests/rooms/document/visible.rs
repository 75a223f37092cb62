//! Tests of `core/src/document/visible.rs`.

use bmv::document::visible::*;
use std::borrow::Cow;

#[test]
fn marks_that_turn_the_direction_of_writing_are_hidden_and_letters_are_not() {
    for hidden in ['\u{202e}', '\u{2067}', '\u{200b}', '\u{feff}', '\u{9b}', '\n', '\u{61c}', '\u{e0041}'] {
        assert!(is_hidden(hidden), "{hidden:?}");
    }
    for shown in ['a', 'ä', '温', 'µ', '°', ' ', '-', '\u{a0}'] {
        assert!(!is_hidden(shown), "{shown:?}");
    }
}

#[test]
fn hidden_characters_are_shown_by_their_codes() {
    assert_eq!(escaped("a\u{1b}[2J\u{202e}\n\0ä"), "a\\u{1b}[2J\\u{202e}\\n\\u{0}ä");
    assert_eq!(escaped_lines("a\n\tb\r"), "a\n\tb\\r");
    assert!(matches!(escaped("plain"), Cow::Borrowed(_)));
}

#[test]
fn json_means_the_same_with_its_hidden_characters_escaped() {
    let value = serde_json::json!({"a\u{202e}": ["\u{9b}\u{e0041}ä", 1.5]});
    let text = serde_json::to_string_pretty(&value).expect("JSON");
    let shown = escaped_json(&text);
    assert!(shown.contains("\\u202e") && shown.contains("\\u009b\\udb40\\udc41ä"), "{shown}");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
}

#[test]
fn a_shell_reads_a_word_as_it_is() {
    assert_eq!(shell_word("conductive-path:box:plate"), "conductive-path:box:plate");
    assert_eq!(shell_word("product-load:box:T_pl*Q"), "'product-load:box:T_pl*Q'");
    assert_eq!(shell_word("sensor-bias:TC o'clock"), "'sensor-bias:TC o'\\''clock'");
    assert_eq!(shell_word(""), "''");
}

#[test]
fn long_texts_keep_both_ends() {
    let text = format!("begin{}end", "ä".repeat(5000));
    let short = shortened(&text);
    assert!(short.starts_with("begin") && short.ends_with("end") && short.chars().count() < 1300);
    assert!(short.contains("(3808 characters)"), "{short}");
    assert_eq!(shortened("as it is"), "as it is");
}
