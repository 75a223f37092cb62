//! Tests of `src/report/markdown.rs`.

use bmv::report::markdown::*;
use bmv::report::page::Page;

#[test]
fn hostile_text_is_no_markup() {
    assert_eq!(escape("<img src=x>|`a`"), "&lt;img src=x&gt;\\|\\`a\\`");
    assert_eq!(escape("[a](https://example.org)\n# b"), "\\[a\\](https&#58;//example.org) \\# b");
    assert_eq!(at_line_start("1. no list"), "1\\. no list");
    assert_eq!(at_line_start("- no list"), "\\- no list");
}

#[test]
fn a_title_cannot_turn_the_line() {
    let text = render(&Page { title: "a\u{1b}[2J\u{202e}b".into(), ..Page::default() });
    assert!(text.starts_with("# a \\[2J\\u{202e}b\n"), "{text:?}");
}

#[test]
fn code_spans_hold_backticks_and_tables_hold_pipes() {
    assert_eq!(code("a`b", false), "``a`b``");
    assert_eq!(code("`", false), "`` ` ``");
    assert_eq!(code("a|b", true), "a\\|b");
    assert_eq!(code("", false), "");
}
