//! The columns of a data file that a measurement uses.

use std::sync::Arc;

use crate::document::hash::sha256_hex;
use crate::document::quantity::{parse_unit, report_dimension};
use crate::document::{Diagnostic, Diagnostics, Map, Place, Sense, Source, Span, Spanned, WrittenUnit, code, suggest};
use crate::expression::{Dimension, Unit};
use crate::study::inherit::folder_diagnostic_at;
use crate::study::pass::measurement::{ColumnForm, PinForm};
use crate::study::pinned::Pinned;
use crate::study::table::{Cells, Column, Header, Problems, Table};

use super::scope::Scope;

/// Length of a SHA-256 in hexadecimal digits.
const DIGITS: usize = 64;

/// A data file's text and hash.
pub struct Data {
    /// The text.
    pub source: Arc<Source>,
    /// SHA-256 of the bytes.
    pub sha256: String,
    /// The character between cells.
    pub separator: u8,
}

impl Data {
    /// The place of a cell: row below the headers and column, both from 0. The whole file where there is none.
    pub fn cell(&self, row: usize, column: usize) -> Place {
        let table = Table::new(self.source.text(), self.separator, &mut Problems::default());
        let range = table.and_then(|table| table.cell(row, column)).unwrap_or(0..0);
        Place::in_text(&self.source, Span::new(range.start, range.end))
    }
}

/// What is wrong has been reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reported;

/// How a table is laid out.
pub struct Layout<'a> {
    /// Columns with other headers or units.
    pub columns: &'a Map<ColumnForm>,
    /// Sensors of the measurement, those among them whose columns are not wanted: they are left out for a reason.
    pub sensors: Vec<&'a str>,
    /// `phase` or `time`: what the rows are.
    pub key: &'static str,
}

impl Layout<'_> {
    /// Whether a header is that of the column of this name.
    fn names(&self, name: &str, header: &Header) -> bool {
        match self.columns.get(name).and_then(|entry| entry.value.header.as_ref()) {
            Some(text) => header.text == text.value.trim(),
            None => header.name == name,
        }
    }
}

/// A column that is wanted.
pub struct Wanted<'a> {
    /// The name.
    pub name: &'a str,
    /// Where the study asks for it.
    pub place: &'a Place,
    /// Dimension of the values, where known.
    pub dimension: Option<Dimension>,
    /// Whether they stand on a scale.
    pub sense: Sense,
    /// How cells are read.
    pub cells: Cells,
    /// Whether the column must be there.
    pub required: bool,
}

/// A column that was read.
pub struct Read {
    /// Where it stands.
    pub origin: Origin,
    /// Values, SI.
    pub values: Vec<Option<f64>>,
}

/// Where a column stands in its file, and its unit.
pub struct Origin {
    /// Column of the file.
    pub column: usize,
    /// The unit, at the place in the file or in the pass where it is stated.
    pub unit: WrittenUnit,
}

/// The wanted columns of a file.
pub struct Columns {
    /// Names of phases, where the rows are phases.
    pub phases: Vec<String>,
    /// One for each wanted column; `None` where there is none and it need not be.
    pub read: Vec<Option<Read>>,
    /// Headers that nothing uses.
    pub unused: Vec<String>,
    /// Of these the columns that belong to no sensor, not even to one that is left out.
    pub spare: Vec<Header>,
}

/// Checks a pin and gives it its plain form.
pub fn pin(measurement: &str, file: &str, form: &PinForm, diagnostics: &mut Diagnostics) -> Option<Pinned> {
    let mut refuse = |place: &Place, message: String, expected: &str| {
        diagnostics.push(Diagnostic::error(&code::PINNED, place, message).expected(expected));
        None
    };
    let sha256 = form.sha256.value.to_ascii_lowercase();
    if sha256.len() != DIGITS || !sha256.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        let message = format!("`{}` is no SHA-256", form.sha256.value);
        return refuse(&form.sha256.place, message, "64 hexadecimal digits");
    }
    if let Some(origin) = form.origin.as_ref().filter(|origin| !origin.value.starts_with("https://")) {
        let message = format!("`{}` cannot be fetched", origin.value);
        return refuse(&origin.place, message, "an address that begins with https://");
    }
    Some(Pinned {
        measurement: measurement.to_owned(),
        file: file.to_owned(),
        sha256,
        bytes: form.bytes,
        origin: form.origin.as_ref().map(|origin| origin.value.clone()),
        licence: form.licence.clone(),
    })
}

/// Reads a data file. `Ok(None)` where it is pinned and not there; `Err` after an error.
pub fn data(
    scope: &mut Scope,
    file: &Spanned<String>,
    separator: u8,
    pinned: Option<&Pinned>,
) -> Result<Option<Data>, Reported> {
    let bytes = match scope.folder.read_table(&file.value) {
        Ok(bytes) => bytes,
        Err(crate::study::folder::FolderError::Missing { .. }) if pinned.is_some() => return Ok(None),
        Err(error) => {
            let mut diagnostic = folder_diagnostic_at(&error, &file.place);
            let near = nearest_file(scope, &file.value);
            if diagnostic.code == &code::FILE_MISSING {
                diagnostic = diagnostic.suggest(near.as_deref());
            }
            scope.diagnostics.push(diagnostic);
            return Err(Reported);
        }
    };
    let sha256 = sha256_hex(&bytes);
    if let Some(pinned) = pinned.filter(|pinned| pinned.sha256 != sha256) {
        let message = format!("`{}` has SHA-256 {sha256}, pinned is {}", file.value, pinned.sha256);
        scope.diagnostics.push(
            Diagnostic::error(&code::PINNED, &file.place, message)
                .expected("not the pinned file")
                .help("move the file away, then `bmv data get` brings the pinned one"),
        );
        return Err(Reported);
    }
    let before = scope.diagnostics.errors();
    let source = crate::document::json::decode(&scope.folder.shown_name(&file.value), bytes, scope.diagnostics);
    if scope.diagnostics.errors() > before { Err(Reported) } else { Ok(Some(Data { source, sha256, separator })) }
}

/// A file of the same folder with nearly this name.
fn nearest_file(scope: &Scope, file: &str) -> Option<String> {
    let (below, name) = file.rsplit_once('/').unwrap_or((".", file));
    let entries = std::fs::read_dir(scope.folder.place(&format!("{below}/{name}")).ok()?.parent()?).ok()?;
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    let near = suggest::nearest(name, names.iter().map(String::as_str))?;
    Some(if below == "." { near.to_owned() } else { format!("{below}/{near}") })
}

/// Reads the wanted columns of a file. `Err` after errors.
pub fn columns(scope: &mut Scope, data: &Data, layout: &Layout, wanted: &[Wanted]) -> Result<Columns, Reported> {
    let before = scope.diagnostics.errors();
    let mut problems = Problems::default();
    let table = Table::new(data.source.text(), data.separator, &mut problems);
    let Some(table) = table else {
        problems.report(&data.source, scope.diagnostics);
        return Err(Reported);
    };
    let headers = table.headers();
    for entry in layout.columns {
        let name = entry.name.as_str();
        let is_wanted = || wanted.iter().any(|wanted| wanted.name == name);
        if name != layout.key && !layout.sensors.contains(&name) && !is_wanted() {
            let mut names: Vec<&str> = vec![layout.key];
            names.extend(wanted.iter().map(|wanted| wanted.name));
            scope.unknown(&code::TABLE_COLUMN, "sensor or input", &entry.name, &entry.name_place, &names);
        }
    }
    // The rows' own column first.
    let mut asked: Vec<(usize, Cells)> = Vec::new();
    let steady = layout.key == "phase";
    let key_place = Place::in_text(&data.source, first_line(data.source.text()));
    let key = find(scope, &data.source, headers, layout, layout.key, &key_place, true);
    let mut placed: Vec<Option<(usize, WrittenUnit)>> = Vec::new();
    if steady {
        asked.extend(key.map(|index| (index, Cells::Names)));
    }
    for wanted in wanted {
        let index = if wanted.name == layout.key {
            key
        } else {
            find(scope, &data.source, headers, layout, wanted.name, wanted.place, wanted.required)
        };
        let index_and_unit =
            index.and_then(|index| Some((index, unit(scope, &data.source, &headers[index], layout, wanted)?)));
        if let Some((index, _)) = &index_and_unit {
            asked.push((*index, wanted.cells));
        }
        placed.push(index_and_unit);
    }
    let mut columns = table.read(&asked, &mut problems).into_iter();
    if problems.report(&data.source, scope.diagnostics) || scope.diagnostics.errors() > before {
        return Err(Reported);
    }
    let phases =
        if steady { columns.next().map_or_else(Vec::new, |column| column.names().to_vec()) } else { Vec::new() };
    let mut read = Vec::new();
    for (wanted, placed) in wanted.iter().zip(&placed) {
        read.push(placed.as_ref().and_then(|(index, unit)| {
            let column = columns.next()?;
            let values = converted(&column, &unit.unit, wanted.sense);
            Some(Read { origin: Origin { column: *index, unit: unit.clone() }, values })
        }));
    }
    let is_asked = |index: usize| asked.iter().any(|(used, _)| *used == index);
    let unused: Vec<&Header> =
        (0..headers.len()).filter(|&index| !is_asked(index)).map(|index| &headers[index]).collect();
    let of_sensor = |header: &&&Header| layout.sensors.iter().any(|sensor| layout.names(sensor, header));
    let spare = unused.iter().filter(|header| !of_sensor(header)).map(|&header| header.clone()).collect();
    Ok(Columns { phases, read, unused: unused.iter().map(|header| header.text.clone()).collect(), spare })
}

fn converted(column: &Column, unit: &Unit, sense: Sense) -> Vec<Option<f64>> {
    let si = |value: f64| match sense {
        Sense::Absolute => unit.to_si(value),
        Sense::Difference => unit.difference_to_si(value),
    };
    column.numbers().iter().map(|value| value.map(si)).collect()
}

fn first_line(text: &str) -> Span {
    Span::new(0, text.find('\n').unwrap_or(text.len()))
}

/// Position of a column; reported where it is missing (if it must be there) or stands twice.
fn find(
    scope: &mut Scope,
    source: &Arc<Source>,
    headers: &[Header],
    layout: &Layout,
    name: &str,
    place: &Place,
    required: bool,
) -> Option<usize> {
    let declared = layout.columns.get(name);
    let declared_header = declared.and_then(|entry| entry.value.header.as_ref());
    let matching: Vec<usize> = (0..headers.len()).filter(|index| layout.names(name, &headers[*index])).collect();
    match (matching.as_slice(), declared) {
        ([index], _) => Some(*index),
        ([first, second, ..], _) => {
            let at = |index: usize| in_table(source, &headers[index]);
            let message = format!("the column `{}` stands twice", headers[*second].text);
            scope.diagnostics.push(
                Diagnostic::error(&code::TABLE_COLUMN, &at(*second), message)
                    .expected("which one is meant?")
                    .related(&at(*first), "the first one"),
            );
            None
        }
        ([], None) if !required => None,
        ([], _) => {
            let looked = declared_header.map_or(name, |text| text.value.as_str());
            let place = declared_header.map_or(place, |text| &text.place);
            let names: Vec<&str> = headers
                .iter()
                .map(|header| if declared_header.is_some() { header.text.as_str() } else { header.name.as_str() })
                .collect();
            let near = scope.diagnostics.nearest(looked, names.iter().copied());
            let listed = suggest::listed(names.iter().copied(), 12);
            let message = format!("`{}` has no column `{looked}`", source.name());
            let mut diagnostic = Diagnostic::error(&code::TABLE_COLUMN, place, message)
                .expected(format!("the columns are {listed}"))
                .suggest(near);
            if near.is_none() && declared_header.is_none() {
                diagnostic = diagnostic.help(format!(
                    "declare it: \"columns\": {{\"{name}\": {{\"header\": \"...\", \"unit\": \"...\"}}}}"
                ));
            }
            scope.diagnostics.push(diagnostic);
            None
        }
    }
}

fn in_table(source: &Arc<Source>, header: &Header) -> Place {
    Place::in_text(source, Span::new(header.range.start, header.range.end))
}

/// The unit of a column, of the right dimension.
fn unit(
    scope: &mut Scope,
    source: &Arc<Source>,
    header: &Header,
    layout: &Layout,
    wanted: &Wanted,
) -> Option<WrittenUnit> {
    let declared = layout.columns.get(wanted.name).and_then(|entry| entry.value.unit.as_ref());
    let place = in_table(source, header);
    let (unit, place) = match (declared, &header.unit) {
        (Some(WrittenUnit { unit, place }), _) => (unit.clone(), place.clone()),
        (None, Some(text)) => (parse_unit(text, &place, 0, scope.diagnostics)?, place),
        (None, None) => {
            let message = format!("the column `{}` states no unit", header.text);
            let unit = wanted.dimension.map_or_else(|| "unit".to_owned(), |dimension| dimension.to_string());
            let help = format!("write `{} [{unit}]`, or declare its unit under \"columns\"", header.name);
            scope.diagnostics.push(Diagnostic::error(&code::TABLE_COLUMN, &place, message).help(help));
            return None;
        }
    };
    if let Some(expected) = wanted.dimension.filter(|expected| *expected != unit.dimension) {
        report_dimension(&unit, &place, expected, scope.diagnostics);
        return None;
    }
    Some(WrittenUnit { unit, place })
}

/// A column of texts, which may be the same in several rows; `None` where the file has no such column. A cell that is empty is an
/// error.
pub fn texts(scope: &mut Scope, data: &Data, name: &str) -> Result<Option<Vec<String>>, Reported> {
    let mut problems = Problems::default();
    let Some(table) = Table::new(data.source.text(), data.separator, &mut problems) else {
        problems.report(&data.source, scope.diagnostics);
        return Err(Reported);
    };
    let Some(column) = table.headers().iter().position(|header| header.name == name) else { return Ok(None) };
    let mut texts = Vec::new();
    table.rows(1, &mut problems, |cells, problems| {
        let text = table.text(&cells[column]).into_owned();
        if text.is_empty() {
            let message = format!("the `{name}` of this row is empty");
            problems.add(&code::TABLE_CELL, cells[column].clone(), message, None);
        }
        texts.push(text);
    });
    if problems.report(&data.source, scope.diagnostics) { Err(Reported) } else { Ok(Some(texts)) }
}

/// Columns of numbers (SI), none of which is missing, in the order wanted.
pub fn numbers(scope: &mut Scope, data: &Data, wanted: &[Wanted]) -> Result<Vec<Vec<f64>>, Reported> {
    let before = scope.diagnostics.errors();
    let mut problems = Problems::default();
    let Some(table) = Table::new(data.source.text(), data.separator, &mut problems) else {
        problems.report(&data.source, scope.diagnostics);
        return Err(Reported);
    };
    let (columns, headers) = (Map::default(), table.headers());
    let layout = Layout { columns: &columns, sensors: Vec::new(), key: "" };
    let (mut asked, mut units) = (Vec::new(), Vec::new());
    for wanted in wanted {
        let index = find(scope, &data.source, headers, &layout, wanted.name, wanted.place, true);
        let unit = index.and_then(|index| unit(scope, &data.source, &headers[index], &layout, wanted));
        if let (Some(index), Some(unit)) = (index, unit) {
            asked.push((index, Cells::Numbers));
            units.push(unit);
        }
    }
    let read = table.read(&asked, &mut problems);
    if problems.report(&data.source, scope.diagnostics) || scope.diagnostics.errors() > before {
        return Err(Reported);
    }
    let senses = wanted.iter().map(|wanted| wanted.sense);
    let read = read.iter().zip(&units).zip(senses).map(|((column, unit), sense)| converted(column, &unit.unit, sense));
    Ok(read.map(|values| values.into_iter().flatten().collect()).collect())
}
