//! Tests of `core/src/document/diagnostic.rs`.

use bmv::document::code;
use bmv::document::diagnostic::*;
use bmv::document::source::{JsonPath, Place, Source, Span};
use bmv::document::visible::is_hidden;

fn at(text: &str, start: usize, end: usize) -> Place {
    Place::in_text(&Source::new("a.csv", text), Span::new(start, end))
}

#[test]
fn any_place_of_any_text_renders() {
    for text in ["", "\n", "ab", "Ω\r\n\tΩ", "a\n\n", "\u{feff}x"] {
        for start in 0..=text.len() + 1 {
            for end in 0..=text.len() + 1 {
                let diagnostic = Diagnostic::error(&code::SYNTAX, &at(text, start, end), "wrong").expected("right");
                assert!(diagnostic.render(false).contains("wrong"));
            }
        }
    }
}

#[test]
fn long_lines_are_cut_and_keep_their_line_number() {
    let text = format!("\n{}x{}", "a".repeat(50_000), "b".repeat(50_000));
    let shown = Diagnostic::error(&code::SYNTAX, &at(&text, 50_001, 50_002), "wrong").render(false);
    assert!(shown.len() < 1000, "{}", shown.len());
    assert!(shown.contains("a.csv:2:50001"), "{shown}");
}

#[test]
fn findings_are_ordered_capped_and_counted() {
    let mut diagnostics = Diagnostics::new();
    let source = Source::new("a", "abcdef");
    let place = |i| Place::in_text(&source, Span::new(i, i + 1));
    diagnostics.push(Diagnostic::warning(&code::SYNTAX, &place(0), "first"));
    diagnostics.push(Diagnostic::error(&code::SYNTAX, &place(3), "third"));
    diagnostics.push(Diagnostic::error(&code::SYNTAX, &place(1), "second"));
    let messages: Vec<String> = diagnostics.plain().into_iter().map(|d| d.message).collect();
    assert_eq!(messages, ["second", "third", "first"]);
    assert_eq!((diagnostics.errors(), diagnostics.warnings()), (2, 1));
    assert!(diagnostics.render(false, 2).ends_with("and 1 more\n"));
    for _ in 0..2 * KEPT {
        diagnostics.push(Diagnostic::error(&code::SYNTAX, &place(1), "again"));
    }
    assert!(diagnostics.render(false, 1).ends_with(&format!("and {} more\n", 2 * KEPT + 2)));
}

#[test]
fn no_part_of_a_finding_passes_on_what_steers_a_terminal() {
    let wild = "x\u{1b}[31m\u{7}\0\u{202e}\u{9b}2J\u{200b}";
    let source = Source::new(format!("{wild}.json"), format!("{wild} {wild}\r\n"));
    let place = |start, end| Place {
        source: source.clone(),
        span: Span::new(start, end),
        path: JsonPath::root().key(wild).index(0),
    };
    let finding = Diagnostic::error(&code::SYNTAX, &place(0, 3), wild)
        .expected(wild)
        .help(format!("write\n{wild}"))
        .related(&place(4, 6), wild);
    for coloured in [false, true] {
        let shown = finding.render(coloured);
        // The renderer's own colours are all that may be left.
        let plain: String = if coloured {
            let after_code = |part: &str| part.split_once('m').map_or(String::new(), |(_, rest)| rest.to_owned());
            let mut parts = shown.split("\u{1b}[");
            parts.next().map(str::to_owned).into_iter().chain(parts.map(after_code)).collect()
        } else {
            shown
        };
        let bad = |character: char| is_hidden(character) && character != '\n';
        assert!(!plain.contains(bad), "{plain:?}");
        assert!(plain.contains("x\\u{1b}[31m\\u{7}\\u{0}\\u{202e}"), "{plain}");
    }
}

#[test]
fn texts_beyond_reading_are_cut() {
    let mut diagnostics = Diagnostics::new();
    let long = "x".repeat(1_000_000);
    diagnostics.push(Diagnostic::error(&code::SYNTAX, &at("a", 0, 1), long.clone()).expected(long.clone()).help(long));
    assert!(diagnostics.render(false, 9).len() < 10_000);
    assert!(diagnostics.plain()[0].message.len() < 2000);
}

#[test]
fn a_finding_of_a_file_that_several_name_is_counted_once() {
    let finding = |start| Diagnostic::error(&code::SYNTAX, &at("abc", start, start + 1), "wrong");
    let (mut one, mut two) = (Diagnostics::new(), Diagnostics::new());
    one.push(finding(0));
    two.push(finding(0));
    two.push(finding(1));
    let rest = two.without(&one);
    assert_eq!((rest.errors(), rest.plain().len()), (1, 1));
    one.extend(&two);
    assert_eq!((one.errors(), one.plain().len()), (2, 2));
}

#[test]
fn names_are_suggested_up_to_a_hundred_errors() {
    let mut diagnostics = Diagnostics::new();
    for _ in 0..100 {
        assert_eq!(diagnostics.nearest("nodse", ["nodes"]), Some("nodes"));
        diagnostics.push(Diagnostic::error(&code::SYNTAX, &at("a", 0, 1), "wrong"));
    }
    assert_eq!(diagnostics.nearest("nodse", ["nodes"]), None);
}
