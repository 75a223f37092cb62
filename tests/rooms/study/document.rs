//! Tests of `src/study/document.rs`.

use std::sync::Arc;

use bmv::document::Diagnostics;
use bmv::study::document::*;
use bmv::study::folder::Folder;

const WHOLE: &str =
    r#"{"format": "bmv-document/1", "title": "Plate", "number": "P-1", "issue": "1", "date": "2026-06-30"}"#;

fn read(text: &str) -> (Option<Arc<StudyDocument>>, String) {
    let root = tempfile::tempdir().expect("a folder");
    std::fs::write(root.path().join(FILE), text).expect("written");
    std::fs::write(root.path().join("pass-1.json"), "{}").expect("written");
    let mut diagnostics = Diagnostics::new();
    let document = load(&Folder::open(root.path()).expect("opened"), &mut diagnostics);
    (document, diagnostics.render(false, 10))
}

#[test]
fn a_document_needs_its_title_block_and_nothing_else() {
    let (document, said) = read(WHOLE);
    let document = document.expect("read");
    assert_eq!((said.as_str(), document.number.as_str(), &document.approver), ("", "P-1", &None));
}

#[test]
fn what_is_wrong_is_reported_at_its_place() {
    let cases = [
        ("2026-06-30", "2026-06-31", "document.json:1:87", "`2026-06-31` is no day", "such as \"2026-06-30\""),
        ("\"P-1\"", "\" \"", "document.json:1:58", "the document has no number", "its number"),
        ("\"issue\"", "\"isue\"", "document.json:1:65", "unknown field `isue`", "did you mean `issue`?"),
        (
            "\"2026-06-30\"",
            "\"2026-06-30\", \"not_archived\": {\"pass-2.json\": \"large\"}",
            "document.json:1:118",
            "the study has no pass `pass-2.json`",
            "such as \"pass-1.json\"",
        ),
        (
            "\"2026-06-30\"",
            "\"2026-06-30\", \"counterparts\": {\"of\": \"T\", \"items\": [{\"item\": \"1\", \"title\": \"t\", \"pass\": \"pass-1.json\"}]}",
            "document.json:1:139",
            "where `1` has its counterpart is not clear",
            "`pass` with either `figure` or `section`",
        ),
        (
            "\"2026-06-30\"",
            "\"2026-06-30\", \"counterparts\": {\"of\": \"T\", \"items\": [{\"item\": \"1\", \"title\": \"t\", \"pass\": \"pass-7.json\", \"figure\": \"network\"}]}",
            "document.json:1:175",
            "the study has no pass `pass-7.json`",
            "\"study\": \"NAME\"",
        ),
        ("Plate", &"x".repeat(301), "document.json:1:39", "with 301 characters", "at most 300 characters"),
        (
            "\"2026-06-30\"",
            &format!("\"2026-06-30\", \"summary\": \"{}\"", "x".repeat(2001)),
            "document.json:1:112",
            "a summary with 2001 characters",
            "at most 2000 characters",
        ),
        (
            "\"2026-06-30\"",
            &format!("\"2026-06-30\", \"assumptions\": [\"short\", \"{}\"]", "x".repeat(601)),
            "document.json:1:126",
            "an assumption with 601 characters",
            "at most 600 characters",
        ),
        (
            "\"2026-06-30\"",
            &format!("\"2026-06-30\", \"assumptions\": [{}\"b\"]", "\"a\", ".repeat(100)),
            "document.json:1:617",
            "101 assumptions",
            "at most 100",
        ),
        ("bmv-document/1", "bmv-document/2", "document.json:1:12", "bmv-document/2", "bmv-document/1"),
    ];
    for (from, to, place, message, help) in cases {
        let (_, said) = read(&WHOLE.replace(from, to));
        for part in [place, message, help] {
            assert!(said.contains(part), "{to}: no `{part}` in\n{said}");
        }
    }
}

#[test]
fn days_are_those_of_the_calendar() {
    for day in ["2024-02-29", "2000-02-29", "2026-12-31"] {
        assert!(is_day(day), "{day}");
    }
    for day in ["2026-02-29", "1900-02-29", "2026-00-10", "2026-13-01", "2026-4-01", "30.06.2026", "2026-06-00", ""] {
        assert!(!is_day(day), "{day}");
    }
}
