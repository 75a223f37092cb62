//! The numbers that a program wrote.

use std::path::Path;

use serde_json::Value;

use super::call::Failure;
use super::command::absent;
use super::process::MOST_BYTES;
use crate::study::external::{Command, Output, Place, Separator, Table};
use crate::study::file;

/// Characters shown of a cell or value that is no number.
const SHOWN: usize = 40;

/// What a program left behind.
pub(super) struct Outputs<'a> {
    /// Folder in which it ran.
    pub folder: &'a Path,
    /// What it wrote to its standard output.
    pub output: &'a Path,
    /// The program.
    pub command: &'a Command,
}

/// A file that was read.
enum Content {
    Json(Value),
    Text(String),
}

impl Outputs<'_> {
    /// The number of each output.
    pub fn numbers(&self, outputs: &[Output]) -> Result<Vec<f64>, Failure> {
        let cannot = |detail: String| Failure::at("an output of the program cannot be read", detail);
        // A file has several outputs, often hundreds.
        let mut read: Vec<(&Option<String>, bool, Content)> = Vec::new();
        let mut numbers = Vec::new();
        for (output, (name, place)) in outputs.iter().zip(&self.command.outputs) {
            let is_json = matches!(place, Place::Json(_));
            let shown = name.as_ref().map_or_else(|| "its standard output".to_owned(), |name| format!("`{name}`"));
            let position = match read.iter().position(|(other, json, _)| *other == name && *json == is_json) {
                Some(position) => position,
                None => {
                    let content =
                        self.content(name.as_deref(), is_json).map_err(|why| cannot(format!("{shown}: {why}")))?;
                    read.push((name, is_json, content));
                    read.len() - 1
                }
            };
            let number = match (&read[position].2, place) {
                (Content::Json(value), Place::Json(pointer)) => at_pointer(value, pointer),
                (Content::Text(text), Place::Csv(table)) => in_table(text, table),
                _ => Err("it was read in another way".to_owned()),
            };
            numbers.push(number.map_err(|why| cannot(format!("`{}` in {shown}: {why}", output.name)))?);
        }
        Ok(numbers)
    }

    fn content(&self, name: Option<&str>, is_json: bool) -> Result<Content, String> {
        let place = name.map_or_else(|| self.output.to_owned(), |name| self.folder.join(name));
        let bytes = file::read(&place, MOST_BYTES).map_err(|error| absent(&error))?;
        if is_json {
            return serde_json::from_slice(&bytes).map(Content::Json).map_err(|error| no_json(&bytes, &error));
        }
        Ok(Content::Text(String::from_utf8_lossy(&bytes).into_owned()))
    }
}

/// That a text is no JSON; a number that is none, as many languages write it, is named.
pub fn no_json(bytes: &[u8], error: &serde_json::Error) -> String {
    const NONE: [&str; 3] = ["nan", "inf", "-inf"];
    let text = String::from_utf8_lossy(bytes);
    let line = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    // The column is that of the character that is wrong, or of the one before it.
    let from = |back: usize| line.chars().skip(error.column().saturating_sub(back));
    let word = |back: usize| from(back).take_while(|c| c.is_alphabetic() || *c == '-').collect::<String>();
    let is_none = |word: &String| NONE.iter().any(|none| word.to_lowercase().starts_with(none));
    match [word(2), word(1), word(0)].into_iter().find(is_none) {
        Some(word) => format!(
            "{} is not JSON (line {}): print a number, or end with another exit code where there is none",
            shown(&word),
            error.line()
        ),
        None => format!("it is no JSON: {error}"),
    }
}

fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(SHOWN).collect()
}

/// The number at a JSON pointer.
///
/// # Errors
/// What is there instead.
pub fn at_pointer(value: &Value, pointer: &str) -> Result<f64, String> {
    let found = value.pointer(pointer).ok_or_else(|| format!("there is nothing at `{pointer}`"))?;
    found.as_f64().ok_or_else(|| format!("`{pointer}` is {}, which is no number", shown(&found.to_string())))
}

/// The cells of a line.
fn cells(line: &str, separator: Separator) -> Vec<String> {
    let bare = |cell: &str| cell.trim().trim_matches('"').trim().to_owned();
    match separator {
        Separator::Character(character) => line.split(character).map(bare).collect(),
        Separator::Blanks => line.split_whitespace().map(bare).collect(),
    }
}

/// The number in a cell of a table.
///
/// # Errors
/// What is there instead.
pub fn in_table(text: &str, table: &Table) -> Result<f64, String> {
    let skip = usize::try_from(table.skip).unwrap_or(usize::MAX);
    let mut lines = text.lines().skip(skip).filter(|line| !line.trim().is_empty());
    let headers = if table.header {
        cells(lines.next().ok_or("it has no line of headers")?, table.separator)
    } else {
        Vec::new()
    };
    let column = |name: &str| -> Result<usize, String> {
        let by_name = headers.iter().position(|header| header == name);
        let by_number = || name.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        by_name.or_else(by_number).ok_or_else(|| format!("there is no column `{name}`"))
    };
    let wanted = column(&table.column)?;
    let condition: Vec<(usize, &str)> =
        table.condition.iter().map(|(name, text)| Ok((column(name)?, text.as_str()))).collect::<Result<_, String>>()?;
    let mut rows = lines
        .map(|line| cells(line, table.separator))
        .filter(|row| condition.iter().all(|(column, text)| row.get(*column).is_some_and(|cell| cell == text)));
    let row = match table.row {
        Some(number) => rows.nth(usize::try_from(number.saturating_sub(1)).unwrap_or(usize::MAX)),
        None if !condition.is_empty() => rows.next(),
        None => rows.last(),
    };
    let row = row.ok_or_else(|| match table.row {
        Some(number) => format!("there is no row {number}"),
        None => "there is no such row".to_owned(),
    })?;
    let cell = row.get(wanted).ok_or_else(|| format!("its row has no column `{}`", table.column))?;
    // Fortran writes 1.0D+02.
    let number = cell.parse::<f64>().or_else(|_| cell.replace(['D', 'd'], "E").parse());
    number.map_err(|_| format!("{:?} is no number", shown(cell)))
}
