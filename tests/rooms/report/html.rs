//! Tests of `src/report/html.rs`.

use bmv::report::html::in_style;

#[test]
fn a_text_in_a_style_sheet_cannot_end_it() {
    assert_eq!(in_style("Disc 2"), "Disc 2");
    let hostile = in_style("\"; } </style><script>\n\\é");
    assert!(!hostile.contains(['"', '<', '>', ';', '}', '\n', 'é']), "{hostile}");
    assert!(hostile.starts_with("\\22 \\3b  \\7d ") && hostile.ends_with("\\e9 "), "{hostile}");
}
