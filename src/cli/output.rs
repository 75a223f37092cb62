//! Printing: documents on standard output, messages on standard error, tables of text.

use std::io::{self, ErrorKind, Write};

use serde::Serialize;
use serde_json::Value;

/// Lists of more numbers than this are shortened for people.
const LONGEST_LIST: usize = 8;

/// Prints text on standard output. A reader that has seen enough (`| head`) is no error.
///
/// # Errors
/// Any other refusal of the system.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Prints one JSON document.
///
/// # Errors
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(io::Error::other)?;
    print(&format!("{text}\n"))
}

/// Tells something on standard error; a closed one is no error.
pub fn tell(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}

/// Rows of cells in columns, two blanks apart; the first row is the heading.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            let fill = " ".repeat(width - cell.chars().count() + 2);
            line.push_str(cell);
            line.push_str(&fill);
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// A JSON value for people: names and values indented, lists of similar things as tables, long lists shortened.
pub fn outline(value: &Value) -> String {
    let mut text = String::new();
    write_outline(value, 0, &mut text);
    text
}

fn write_outline(value: &Value, depth: usize, text: &mut String) {
    let indent = "  ".repeat(depth);
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                if is_short(field) {
                    text.push_str(&format!("{indent}{name}: {}\n", cell(field)));
                } else {
                    text.push_str(&format!("{indent}{name}:\n"));
                    write_outline(field, depth + 1, text);
                }
            }
        }
        Value::Array(items) => match rows(items) {
            Some(rows) => {
                for line in table(&rows).lines() {
                    text.push_str(&format!("{indent}{line}\n"));
                }
            }
            None => {
                for (position, item) in items.iter().enumerate() {
                    if is_short(item) {
                        text.push_str(&format!("{indent}{}\n", cell(item)));
                    } else {
                        text.push_str(&format!("{indent}{}.\n", position + 1));
                        write_outline(item, depth + 1, text);
                    }
                }
            }
        },
        scalar => text.push_str(&format!("{indent}{}\n", cell(scalar))),
    }
}

/// Objects with short fields as a table, headed by their names.
fn rows(items: &[Value]) -> Option<Vec<Vec<String>>> {
    let mut names: Vec<&String> = Vec::new();
    for item in items {
        let fields = item.as_object().filter(|fields| fields.values().all(is_short))?;
        names.extend(fields.keys().filter(|name| !names.contains(name)).collect::<Vec<_>>());
    }
    let mut rows = vec![names.iter().map(|name| (*name).clone()).collect()];
    for item in items {
        rows.push(names.iter().map(|name| item.get(name.as_str()).map_or(String::new(), cell)).collect());
    }
    Some(rows)
}

/// Whether a value fits on a line: a scalar, or a list of scalars.
fn is_short(value: &Value) -> bool {
    let is_scalar = |value: &Value| !matches!(value, Value::Array(_) | Value::Object(_));
    match value {
        Value::Array(items) => items.iter().all(is_scalar),
        Value::Object(fields) => fields.is_empty(),
        _ => true,
    }
}

/// A short value in a line; numbers with six digits, control characters of a study's texts escaped.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => escaped(text),
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(float) if float != 0.0 && !(1e-4..1e7).contains(&float.abs()) => format!("{float:.5e}"),
            Some(float) => six_digits(float),
            None => number.to_string(),
        },
        Value::Array(items) if items.len() > LONGEST_LIST => {
            let first: Vec<_> = items.iter().take(3).map(cell).collect();
            let last = items.last().map(cell).unwrap_or_default();
            format!("{}, ... {last} ({} values)", first.join(", "), items.len())
        }
        Value::Array(items) => items.iter().map(cell).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

fn six_digits(float: f64) -> String {
    let mut before_point = 1;
    let mut rest = float.abs();
    while rest >= 10.0 {
        rest /= 10.0;
        before_point += 1;
    }
    let text = format!("{float:.*}", 6_usize.saturating_sub(before_point));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Text of a study without the characters that steer a terminal.
pub fn escaped(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect::<Vec<_>>() } else { vec![c] }).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let row = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
        assert_eq!(table(&[row("job", "kind"), row("größer", "x")]), "job     kind\ngrößer  x\n");
        assert_eq!(table(&[]), "");
    }

    #[test]
    fn results_read_as_tables_and_lists() {
        let value = json!({
            "samples": 1000, "mean": 293.123456789, "draws": (0..20).collect::<Vec<_>>(), "tiny": 1.25e-9,
            "quantities": [{"name": "a", "sd": 0.5}, {"name": "b", "sd": 12.0}], "empty": {}, "none": null
        });
        let expected = "draws: 0, 1, 2, ... 19 (20 values)\nempty: {}\nmean: 293.123\nnone: -\nquantities:\n  \
                        name  sd\n  a     0.5\n  b     12\nsamples: 1000\ntiny: 1.25000e-9\n";
        assert_eq!(outline(&value), expected);
    }

    #[test]
    fn a_study_cannot_steer_the_terminal() {
        assert_eq!(outline(&json!({"name": "\u{1b}[2Jx\ny"})), "name: \\u{1b}[2Jx\\ny\n");
    }
}
