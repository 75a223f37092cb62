//! Measured data: CSV text with places.
//!
//! A first line of headers, `NAME [unit]`, then a line a row. Blanks round headers and cells are trimmed, an empty
//! cell is a missing reading, empty lines are skipped, quotes are those of RFC 4180. Cells are read column by column
//! as asked for, so that what nothing uses is never an error, and every problem keeps its place in the text. Problems
//! that repeat down a column are reported a few times and then counted.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::document::code::{self, Code};
use crate::document::{Diagnostic, Diagnostics, Place, Source, Span, Spanned, counted};

/// Problems kept of one file; the others are counted.
const PROBLEMS_KEPT: usize = 20;
/// Problems of one kind kept of one column; the others are counted at the last of these.
const ALIKE_KEPT: usize = 3;
/// Most cells that are read of one file.
pub const MOST_CELLS: usize = 10_000_000;

/// Something wrong at a place of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Which kind of finding.
    pub code: &'static Code,
    /// Bytes of the text.
    pub range: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
    /// How many more of its kind there are in its column, behind it.
    pub alike: usize,
}

/// What is wrong with a cell, in general: problems of one kind in one column are counted together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Fault {
    Cells,
    Empty,
    Repeated,
    NotANumber,
    NotFinite,
    Order,
}

/// The problems of a file, the first of them kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems {
    /// The first problems, in the order found.
    pub kept: Vec<Problem>,
    /// How many more there were, those aside that are counted at one that is kept.
    pub more: usize,
    /// Of each kind in each column, how many are kept and which is the last.
    kinds: HashMap<(usize, Fault), (usize, Option<usize>)>,
}

impl Problems {
    /// Adds a problem.
    pub fn add(&mut self, code: &'static Code, range: Range<usize>, message: impl Into<String>, help: Option<&str>) {
        if self.kept.len() < PROBLEMS_KEPT {
            let (message, help) = (message.into(), help.map(str::to_owned));
            self.kept.push(Problem { code, range, message, help, alike: 0 });
        } else {
            self.more += 1;
        }
    }

    /// Adds a problem of a cell of a column, or counts it with its like.
    fn add_like(
        &mut self,
        (column, fault): (usize, Fault),
        range: Range<usize>,
        message: impl FnOnce() -> String,
        help: Option<&str>,
    ) {
        let (count, last) = self.kinds.entry((column, fault)).or_default();
        *count += 1;
        if *count > ALIKE_KEPT {
            match last.and_then(|last| self.kept.get_mut(last)) {
                Some(last) => last.alike += 1,
                None => self.more += 1,
            }
            return;
        }
        *last = (self.kept.len() < PROBLEMS_KEPT).then_some(self.kept.len()).or(*last);
        let code = if fault == Fault::Cells { &code::TABLE_SHAPE } else { &code::TABLE_CELL };
        self.add(code, range, message(), help);
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Adds them to the diagnostics, each said once, however many entries use the file. Whether there are some.
    pub fn report(self, source: &Arc<Source>, diagnostics: &mut Diagnostics) -> bool {
        let Some(last) = self.kept.last().map(|problem| problem.range.clone()) else { return false };
        for problem in self.kept {
            let place = Place::in_text(source, Span::new(problem.range.start, problem.range.end));
            let alike = match problem.alike {
                0 => String::new(),
                more => format!("; and {more} more like it in this column"),
            };
            let mut diagnostic = Diagnostic::error(problem.code, &place, problem.message + &alike);
            diagnostic.help = problem.help;
            diagnostics.push_once(diagnostic);
        }
        if self.more > 0 {
            let place = Place::in_text(source, Span::new(last.start, last.end));
            let message = format!("{} in this file", counted(self.more, "further problem"));
            diagnostics.push_once(Diagnostic::error(&code::TABLE_CELL, &place, message));
        }
        true
    }
}

/// A column's header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// All of it, trimmed.
    pub text: String,
    /// The part before a bracketed unit, or all of it.
    pub name: String,
    /// The unit in brackets, as written.
    pub unit: Option<String>,
    /// Its place.
    pub range: Range<usize>,
}

/// How a column's cells are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Numbers; an empty cell is a missing one.
    Readings,
    /// Numbers; an empty cell is a problem.
    Numbers,
    /// Numbers, each above the one before; an empty cell is a problem.
    Times,
    /// Texts, each once; an empty cell is a problem.
    Names,
}

/// A column's values, one a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Numbers in the unit of the column; `None` is missing.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Names(Vec<String>),
}

impl Column {
    /// The numbers; none of a column of texts.
    pub fn numbers(&self) -> &[Option<f64>] {
        match self {
            Self::Numbers(values) => values,
            Self::Names(_) => &[],
        }
    }

    /// The texts; none of a column of numbers.
    pub fn names(&self) -> &[String] {
        match self {
            Self::Names(values) => values,
            Self::Numbers(_) => &[],
        }
    }
}

/// A CSV text whose headers have been read.
#[derive(Clone, Debug)]
pub struct Table<'t> {
    text: &'t str,
    separator: u8,
    headers: Vec<Header>,
    body: usize,
}

impl<'t> Table<'t> {
    /// Reads the headers. `separator` stands between cells and is an ASCII character.
    pub fn new(text: &'t str, separator: u8, problems: &mut Problems) -> Option<Self> {
        let mut start = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
        let mut cells = Vec::new();
        while start < text.len() {
            let body = record(text, start, separator, &mut cells, problems)?;
            start = body;
            if cells.iter().all(Range::is_empty) {
                continue;
            }
            let headers: Vec<Header> = cells.iter().map(|range| header(&value(text, range), range.clone())).collect();
            if let [only] = headers.as_slice() {
                for (other, name) in [(b';', "`;`"), (b'\t', "`tab`"), (b',', "`,`")] {
                    if other != separator && only.text.as_bytes().contains(&other) {
                        let help = format!("declare the separator: \"separator\": {}", name.replace('`', "\""));
                        problems.add(
                            &code::TABLE_SHAPE,
                            only.range.clone(),
                            "the first line has one column only",
                            Some(&help),
                        );
                        return None;
                    }
                }
            }
            return Some(Self { text, separator, headers, body });
        }
        problems.add(&code::TABLE_EMPTY, 0..0, "the file has no line of headers", None);
        None
    }

    /// The headers in order.
    pub fn headers(&self) -> &[Header] {
        &self.headers
    }

    /// The place of a cell of a row as [`Table::read`] counts them.
    pub fn cell(&self, row: usize, column: usize) -> Option<Range<usize>> {
        let mut ranges = Vec::new();
        let (mut start, mut rows) = (self.body, 0);
        while start < self.text.len() {
            start = record(self.text, start, self.separator, &mut ranges, &mut Problems::default())?;
            if ranges.iter().all(Range::is_empty) || ranges.len() != self.headers.len() {
                continue;
            }
            if rows == row {
                return ranges.get(column).cloned();
            }
            rows += 1;
        }
        None
    }

    /// Reads the cells of the columns asked for, with how to read each. Lines with too few or too many cells are
    /// problems and are left out; a cell that cannot be read is a problem and missing.
    pub fn read(&self, wanted: &[(usize, Cells)], problems: &mut Problems) -> Vec<Column> {
        let mut columns: Vec<Column> = wanted
            .iter()
            .map(|(_, cells)| match cells {
                Cells::Names => Column::Names(Vec::new()),
                Cells::Readings | Cells::Numbers | Cells::Times => Column::Numbers(Vec::new()),
            })
            .collect();
        let mut seen: HashMap<String, ()> = HashMap::new();
        let mut last_times: Vec<Option<f64>> = vec![None; wanted.len()];
        self.rows(wanted.len(), problems, |ranges, problems| {
            for (place, &(index, cells)) in wanted.iter().enumerate() {
                let range = &ranges[index];
                let text = value(self.text, range);
                let name = &self.headers[index].name;
                match &mut columns[place] {
                    Column::Names(values) => {
                        if text.is_empty() {
                            let message = || format!("the `{name}` of this row is empty");
                            problems.add_like((index, Fault::Empty), range.clone(), message, None);
                        } else if seen.insert(text.clone().into_owned(), ()).is_some() {
                            let message = || format!("`{text}` stands twice under `{name}`");
                            problems.add_like((index, Fault::Repeated), range.clone(), message, None);
                        }
                        values.push(text.into_owned());
                    }
                    Column::Numbers(values) => {
                        let number = match number(&text) {
                            Ok(number) => number,
                            Err((fault, message, help)) => {
                                problems.add_like((index, fault), range.clone(), || message, Some(&help));
                                values.push(None);
                                continue;
                            }
                        };
                        if number.is_none() && cells != Cells::Readings {
                            let message = || format!("`{name}` has no value in this row");
                            let help = Some("only a sensor's reading may be missing");
                            problems.add_like((index, Fault::Empty), range.clone(), message, help);
                        }
                        if let (Cells::Times, Some(time)) = (cells, number) {
                            if let Some(last) = last_times[place].filter(|last| time <= *last) {
                                let message = || format!("time {time} is not after {last}, the time of the row before");
                                problems.add_like((index, Fault::Order), range.clone(), message, None);
                            }
                            last_times[place] = Some(time);
                        }
                        values.push(number);
                    }
                }
            }
        });
        columns
    }

    /// Gives the places of the cells of each row, of which `used` are read. Lines with too few or too many cells are
    /// problems and are left out.
    pub fn rows(&self, used: usize, problems: &mut Problems, mut each: impl FnMut(&[Range<usize>], &mut Problems)) {
        let mut ranges = Vec::new();
        let mut cells_read = 0;
        let mut start = self.body;
        while start < self.text.len() {
            let Some(next) = record(self.text, start, self.separator, &mut ranges, problems) else { break };
            start = next;
            if ranges.iter().all(Range::is_empty) {
                continue;
            }
            if ranges.len() != self.headers.len() {
                let range = ranges[0].start..ranges[ranges.len() - 1].end;
                let (cell_count, expected) = (ranges.len(), self.headers.len());
                let message = || format!("this row has {cell_count} cells, the line of headers has {expected}");
                let comma = self.separator == b',' && cell_count > expected;
                let help = comma.then_some(
                    "a decimal is written with a point, 0.6, or the cells are separated by something else than a \
                     comma: \"separator\": \";\"",
                );
                problems.add_like((0, Fault::Cells), range, message, help);
                continue;
            }
            cells_read += used;
            if cells_read > MOST_CELLS {
                let message = format!("the file has more than {MOST_CELLS} cells that are read");
                let help = "thin the record out, or split it into several measurements";
                problems.add(&code::TOO_LARGE, ranges[0].clone(), message, Some(help));
                break;
            }
            each(&ranges, problems);
        }
    }

    /// What a cell says, without its quotes.
    pub fn text(&self, cell: &Range<usize>) -> Cow<'t, str> {
        value(self.text, cell)
    }

    /// The number of a cell of a column; nothing where the cell is empty or holds no number, which is a problem.
    pub fn number(&self, column: usize, cell: &Range<usize>, problems: &mut Problems) -> Option<f64> {
        match number(&self.text(cell)) {
            Ok(number) => number,
            Err((fault, message, help)) => {
                problems.add_like((column, fault), cell.clone(), || message, Some(&help));
                None
            }
        }
    }
}

/// The separator between cells as one ASCII character, a comma where none is written.
pub fn separator(written: Option<&Spanned<String>>, diagnostics: &mut Diagnostics) -> u8 {
    let Some(written) = written else { return b',' };
    match written.value.as_bytes() {
        b"tab" => b'\t',
        [byte] if byte.is_ascii() && !byte.is_ascii_alphanumeric() && !matches!(byte, b'"' | b'.' | b'-' | b'+') => {
            *byte
        }
        _ => {
            let message = format!("`{}` cannot separate cells", written.value);
            let diagnostic = Diagnostic::error(&code::TABLE_SHAPE, &written.place, message);
            diagnostics.push(diagnostic.expected("one character such as `;`, or \"tab\""));
            b','
        }
    }
}

/// Splits the record at `start` into the places of its trimmed cells and gives where the next record starts.
fn record(
    text: &str,
    start: usize,
    separator: u8,
    cells: &mut Vec<Range<usize>>,
    problems: &mut Problems,
) -> Option<usize> {
    cells.clear();
    let bytes = text.as_bytes();
    let mut at = start;
    loop {
        let from = at;
        while at < bytes.len() && matches!(bytes[at], b' ' | b'\t') && bytes[at] != separator {
            at += 1;
        }
        if bytes.get(at) == Some(&b'"') {
            let open = at;
            at += 1;
            loop {
                match bytes.get(at) {
                    None => {
                        problems.add(&code::TABLE_SHAPE, open..open + 1, "this quote is not closed", None);
                        return None;
                    }
                    Some(b'"') if bytes.get(at + 1) == Some(&b'"') => at += 2,
                    Some(b'"') => break,
                    Some(_) => at += 1,
                }
            }
        }
        while at < bytes.len() && bytes[at] != separator && !matches!(bytes[at], b'\n' | b'\r') {
            at += 1;
        }
        cells.push(trimmed(text, from..at));
        match bytes.get(at) {
            Some(byte) if *byte == separator => at += 1,
            Some(_) => return Some(at + 1),
            None => return Some(at),
        }
    }
}

fn trimmed(text: &str, range: Range<usize>) -> Range<usize> {
    let cell = &text[range.clone()];
    let left = cell.trim_start();
    let start = range.start + (cell.len() - left.len());
    start..start + left.trim_end().len()
}

/// What a cell says, without its quotes.
fn value<'t>(text: &'t str, range: &Range<usize>) -> Cow<'t, str> {
    let cell = &text[range.clone()];
    match cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(inner) if inner.contains('"') => Cow::Owned(inner.replace("\"\"", "\"").trim().to_owned()),
        Some(inner) => Cow::Borrowed(inner.trim()),
        None => Cow::Borrowed(cell),
    }
}

fn header(text: &str, range: Range<usize>) -> Header {
    let bracketed = text.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    let (name, unit) = match bracketed {
        Some((name, unit)) => (name.trim(), Some(unit.trim().to_owned())),
        None => (text, None),
    };
    Header { text: text.to_owned(), name: name.to_owned(), unit, range }
}

/// A cell's number; `None` where it is empty. What is wrong with a cell that holds none, and what to write instead.
fn number(cell: &str) -> Result<Option<f64>, (Fault, String, String)> {
    if cell.is_empty() {
        return Ok(None);
    }
    let missing = || "leave the cell of a missing reading empty".to_owned();
    match cell.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(Some(number)),
        Ok(_) => Err((Fault::NotFinite, format!("`{cell}` is not a finite number"), missing())),
        Err(_) => {
            let help = number_with_comma(cell).map(|point| format!("a decimal is written with a point: write {point}"));
            Err((Fault::NotANumber, format!("`{cell}` is not a number"), help.unwrap_or_else(missing)))
        }
    }
}

/// The number that a cell with one decimal comma means, as it should be written: `0,6` is 0.6, `1.234,5` is 1234.5.
fn number_with_comma(cell: &str) -> Option<String> {
    let (whole, fraction) = cell.split_once(',')?;
    let written = format!("{}.{fraction}", whole.replace('.', ""));
    written.parse::<f64>().is_ok_and(f64::is_finite).then_some(written)
}
