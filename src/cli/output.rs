//! Printing: documents on standard output, messages on standard error, tables of text. Whatever a text was made of,
//! nothing in it steers the terminal: this is held here, for all verbs.

use std::borrow::Cow;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;

use serde::Serialize;

use crate::document::visible::{escaped_json, escaped_lines};
pub use crate::report::terminal::escaped;
use crate::report::terminal::wrapped;

/// Text is not broken into lines shorter than this.
const LEAST_ROOM: usize = 20;

/// Begins a sequence of control.
const ESCAPE: &str = "\u{1b}[";

/// A text whose hidden characters are shown by their codes. Line breaks stay, and so do colours, bold and their end, which
/// this program sets itself; no other sequence of control does.
pub fn safe(text: &str) -> Cow<'_, str> {
    if !text.contains(ESCAPE) {
        return escaped_lines(text);
    }
    let mut parts = text.split(ESCAPE);
    let mut out = escaped_lines(parts.next().unwrap_or_default()).into_owned();
    for part in parts {
        let colour = part.split_once('m').filter(|(codes, _)| codes.split(';').all(is_colour));
        let rest = match colour {
            Some((codes, rest)) => {
                out.push_str(&format!("{ESCAPE}{codes}m"));
                rest
            }
            None => {
                out.push_str(&escaped_lines(ESCAPE));
                part
            }
        };
        out.push_str(&escaped_lines(rest));
    }
    Cow::Owned(out)
}

/// Whether a code sets a colour of the text, bold, or nothing.
fn is_colour(code: &str) -> bool {
    match code.parse::<u8>() {
        Ok(code) => matches!(code, 0 | 1 | 22 | 30..=37 | 39 | 90..=97),
        Err(_) => code.is_empty(),
    }
}

/// Prints text on standard output. A reader that has seen enough (`| head`) is no error.
///
/// # Errors
/// Any other refusal of the system.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    or_no_reader(out.write_all(safe(text).as_bytes()).and_then(|()| out.flush()))
}

/// What became of a write on standard output; a reader that has left is no error.
///
/// # Errors
/// Any other refusal of the system.
pub fn or_no_reader(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| if error.kind() == ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
}

/// Prints one JSON document, piece by piece as it is made.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    let mut out = EscapedJson(BufWriter::new(io::stdout().lock()));
    let written = serde_json::to_writer_pretty(&mut out, value).map_err(io::Error::from);
    or_no_reader(written.and_then(|()| out.0.write_all(b"\n")).and_then(|()| out.0.flush()))
}

/// JSON on its way out, whose hidden characters are written as escapes. It comes in pieces of whole characters.
struct EscapedJson<W>(W);

impl<W: Write> Write for EscapedJson<W> {
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        let text = std::str::from_utf8(piece).map_err(|error| io::Error::new(ErrorKind::InvalidData, error))?;
        self.0.write_all(escaped_json(text).as_bytes())?;
        Ok(piece.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Tells something on standard error; a closed one is no error.
pub fn tell(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", safe(message));
}

/// A path as it is printed.
pub fn shown(path: &Path) -> String {
    escaped(&path.display().to_string())
}

/// Rows of cells in columns, two blanks apart; the first row is the heading. Within `fold` characters, where the output is a
/// terminal, the last column is broken at blanks.
pub fn table(rows: &[Vec<String>], fold: Option<usize>) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let Some((last, others)) = row.split_last() else { continue };
        let mut lead = String::new();
        for (cell, width) in others.iter().zip(&widths) {
            lead.push_str(cell);
            lead.push_str(&" ".repeat(width - cell.chars().count() + 2));
        }
        text.push_str(&folded(&lead, last, fold));
    }
    text
}

/// A text after what leads it, with a line's end. Within `fold` characters it is broken at blanks, and the lines that
/// follow begin below its first character; a lead that leaves no room is no reason to break.
pub fn folded(lead: &str, text: &str, fold: Option<usize>) -> String {
    let indent = lead.chars().count();
    let room = fold.and_then(|width| width.checked_sub(indent)).filter(|&room| room >= LEAST_ROOM);
    let lines = room.map_or_else(|| vec![text.to_owned()], |room| wrapped(text, room));
    let mut folded = String::new();
    for (position, line) in lines.iter().enumerate() {
        let before = if position == 0 { lead.to_owned() } else { " ".repeat(indent) };
        folded.push_str(format!("{before}{line}").trim_end());
        folded.push('\n');
    }
    folded
}
