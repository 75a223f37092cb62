//! Printing: documents on standard output, messages on standard error, tables of text.

use std::io::{self, ErrorKind, Write};

use serde::Serialize;

pub use crate::report::terminal::escaped;

/// Prints text on standard output. A reader that has seen enough (`| head`) is no error.
///
/// # Errors
/// Any other refusal of the system.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    or_no_reader(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What became of a write on standard output; a reader that has left is no error.
///
/// # Errors
/// Any other refusal of the system.
pub fn or_no_reader(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| if error.kind() == ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let row = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
        assert_eq!(table(&[row("job", "kind"), row("größer", "x")]), "job     kind\ngrößer  x\n");
        assert_eq!(table(&[]), "");
    }
}
