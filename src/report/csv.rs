//! Cells of CSV files that people open in a spreadsheet (RFC 4180).

use crate::document::visible::escaped;

/// A number as the shortest text that reads back as the same double; empty where it is none.
pub fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { value.to_string() }
}

/// A text, in quotes where it holds what ends a cell. One that a spreadsheet would take for a formula gets an apostrophe before
/// it: names come from a study, and opening a file must compute nothing.
pub fn text(text: &str) -> String {
    let shown = escaped(text);
    let begins = shown.trim_start().starts_with(['=', '+', '-', '@', '\u{FF1D}', '\u{FF0B}', '\u{FF0D}', '\u{FF20}']);
    // A number is no formula, whatever its sign.
    let guard = if begins && shown.parse::<f64>().is_err() { "'" } else { "" };
    if shown.contains(['"', ',']) {
        format!("\"{guard}{}\"", shown.replace('"', "\"\""))
    } else {
        format!("{guard}{shown}")
    }
}
