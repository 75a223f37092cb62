//! Couplings that stand in CSV tables: conductors and radiations by the thousand, a row each.
//!
//! Rows become entries of the model's own objects before anything is read of them, with their places in the table. So
//! a coupling of a table means what the same coupling written as an object means, down to the hash of the definition.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::document::json::{self, Entry, Number};
use crate::document::name::check_symbol;
use crate::document::quantity::{parse_unit, report_dimension};
use crate::document::{
    Diagnostic, Diagnostics, Node, Place, Source, Span, Spanned, Value, Written, canonical, code, suggest,
    written_struct,
};
use crate::expression::{Dimension, Unit};
use crate::study::folder::Folder;
use crate::study::inherit::folder_diagnostic_at;
use crate::study::table::{Header, Problems, Table, separator};

/// The model's member that names the tables.
pub const MEMBER: &str = "tabulated";
/// Most rows of a table: each becomes several values, of which a JSON file has a limited number too.
const MOST_ROWS: usize = json::VALUES / 5;

written_struct! {
    /// Tables of couplings, which add to the conductors and radiations that stand in the model itself.
    pub struct TabulatedForm: "tables of couplings" {
        /// Conductors; `value` is the conductance, W/K.
        optional conductors: CouplingTableForm,
        /// Radiations; `value` is the exchange area, m2.
        optional radiations: CouplingTableForm,
    }
}

written_struct! {
    /// A table of couplings.
    pub struct CouplingTableForm: "a table of couplings, {\"file\": \"data/conductors.csv\"}" {
        /// CSV within the study with the headers `name,from,to,value,parameter,factor`: a `value`, or a `parameter` (or
        /// input) and the `factor` that it is multiplied by (1 where it is empty). `name`, and columns that no row needs,
        /// may be left out; a coupling without a name is called `FROM-TO`.
        required file: Spanned<String>,
        /// The character between cells; `,` where it is left out.
        optional separator: Spanned<String>,
    }
}

/// A kind of coupling: the model's member that holds it, its value's name there, and the dimension.
struct Kind {
    member: &'static str,
    value: &'static str,
    dimension: Dimension,
}

const CONDUCTORS: Kind = Kind { member: "conductors", value: "conductance", dimension: Dimension::CONDUCTANCE };
const RADIATIONS: Kind = Kind { member: "radiations", value: "exchange_area", dimension: Dimension::AREA };

/// The model's tree with the rows of its tables as entries. What is wrong with a table is reported at its place, and the
/// tree comes back without its rows.
pub fn expanded(mut tree: Node, folder: &Folder, diagnostics: &mut Diagnostics) -> Node {
    let Value::Object(members) = &mut tree.value else { return tree };
    let Some(position) = members.iter().position(|entry| entry.key == MEMBER) else { return tree };
    let tables = members.remove(position);
    if tables.node.value == Value::Null {
        return tree;
    }
    let Some(form) = TabulatedForm::read(&tables.node, diagnostics) else { return tree };
    for (kind, table) in [(&CONDUCTORS, &form.conductors), (&RADIATIONS, &form.radiations)] {
        let Some(table) = table else { continue };
        let Some((source, separator)) = text(folder, table, diagnostics) else { continue };
        let written = members.iter_mut().find(|entry| entry.key == kind.member);
        let mut none = Vec::new();
        let before = match written.as_ref().map(|entry| &entry.node.value) {
            Some(Value::Object(entries)) => entries,
            Some(Value::Null) | None => &mut none,
            // Not an object: reported when the model is read.
            Some(_) => continue,
        };
        let rows = Rows::new(kind, &source, before, diagnostics).read(separator);
        match written {
            Some(Entry { node: Node { value: Value::Object(entries), .. }, .. }) => entries.extend(rows),
            Some(entry) => entry.node.value = Value::Object(rows),
            None => members.push(Entry {
                key: kind.member.to_owned(),
                key_place: tables.key_place.clone(),
                node: Node { value: Value::Object(rows), place: tables.node.place.clone() },
            }),
        }
    }
    tree
}

/// The text of a table and its separator.
fn text(folder: &Folder, form: &CouplingTableForm, diagnostics: &mut Diagnostics) -> Option<(Arc<Source>, u8)> {
    let separator = separator(form.separator.as_ref(), diagnostics);
    let bytes = match folder.read_table(&form.file.value) {
        Ok(bytes) => bytes,
        Err(error) => {
            diagnostics.push(folder_diagnostic_at(&error, &form.file.place));
            return None;
        }
    };
    let before = diagnostics.errors();
    let source = json::decode(&folder.shown_name(&form.file.value), bytes, diagnostics);
    (diagnostics.errors() == before).then_some((source, separator))
}

/// Positions of the columns.
#[derive(Default)]
struct Columns {
    name: Option<usize>,
    from: Option<usize>,
    to: Option<usize>,
    value: Option<usize>,
    parameter: Option<usize>,
    factor: Option<usize>,
}

const HEADERS: [&str; 6] = ["name", "from", "to", "value", "parameter", "factor"];

impl Columns {
    fn of(&mut self, name: &str) -> Option<&mut Option<usize>> {
        match name {
            "name" => Some(&mut self.name),
            "from" => Some(&mut self.from),
            "to" => Some(&mut self.to),
            "value" => Some(&mut self.value),
            "parameter" => Some(&mut self.parameter),
            "factor" => Some(&mut self.factor),
            _ => None,
        }
    }
}

/// A row as read: its name where it has one, and what becomes its entry.
struct Row {
    name: Option<(String, Place)>,
    ends: [(String, Place); 2],
    value: Node,
    place: Place,
}

/// Reads the rows of a table.
struct Rows<'a> {
    kind: &'a Kind,
    source: &'a Arc<Source>,
    /// Names of couplings, each with the place that has it.
    names: HashMap<String, Place>,
    diagnostics: &'a mut Diagnostics,
}

impl<'a> Rows<'a> {
    fn new(kind: &'a Kind, source: &'a Arc<Source>, before: &[Entry], diagnostics: &'a mut Diagnostics) -> Self {
        let names = before.iter().map(|entry| (entry.key.clone(), entry.key_place.clone())).collect();
        Self { kind, source, names, diagnostics }
    }

    fn place(&self, range: &Range<usize>) -> Place {
        Place::in_text(self.source, Span::new(range.start, range.end))
    }

    fn error(&mut self, code: &'static code::Code, range: &Range<usize>, message: impl Into<String>, expected: &str) {
        let place = self.place(range);
        self.diagnostics.push(Diagnostic::error(code, &place, message).expected(expected));
    }

    /// The entries; none after an error.
    fn read(mut self, separator: u8) -> Vec<Entry> {
        let before = self.diagnostics.errors();
        let mut problems = Problems::default();
        let source = Arc::clone(self.source);
        let Some(table) = Table::new(source.text(), separator, &mut problems) else {
            problems.report(&source, self.diagnostics);
            return Vec::new();
        };
        let Some((columns, units)) = self.columns(table.headers()) else { return Vec::new() };
        let mut rows = Vec::new();
        let mut count = 0_usize;
        table.rows(HEADERS.len(), &mut problems, |cells, problems| {
            count += 1;
            if count == MOST_ROWS + 1 {
                let message = format!("the table has more than {MOST_ROWS} couplings");
                problems.add(&code::TOO_LARGE, cells[0].clone(), message, None);
            }
            if count <= MOST_ROWS {
                rows.extend(self.row(&table, &columns, &units, cells, problems));
            }
        });
        problems.report(&source, self.diagnostics);
        let entries = self.entries(rows);
        if self.diagnostics.errors() > before { Vec::new() } else { entries }
    }

    /// Positions of the columns, and the units of `value` and `factor`.
    fn columns(&mut self, headers: &[Header]) -> Option<(Columns, [Option<Unit>; 2])> {
        let before = self.diagnostics.errors();
        let (mut columns, mut units) = (Columns::default(), [None, None]);
        let mut is_misspelt = false;
        for (position, header) in headers.iter().enumerate() {
            match columns.of(&header.name) {
                Some(Some(_)) => {
                    let message = format!("the column `{}` stands twice", header.name);
                    self.error(&code::TABLE_COLUMN, &header.range, message, "each column once");
                }
                Some(column) => *column = Some(position),
                None => {
                    is_misspelt = true;
                    let near = self.diagnostics.nearest(&header.name, HEADERS);
                    let message = format!("a table of couplings has no column `{}`", header.name);
                    let expected = format!("the columns are {}", suggest::listed(HEADERS.into_iter(), HEADERS.len()));
                    let place = self.place(&header.range);
                    let diagnostic = Diagnostic::error(&code::TABLE_COLUMN, &place, message);
                    self.diagnostics.push(diagnostic.expected(expected).suggest(near));
                }
            }
            let Some(text) = &header.unit else { continue };
            let place = self.place(&header.range);
            match header.name.as_str() {
                "value" => {
                    let unit = parse_unit(text, &place, 0, self.diagnostics);
                    if let Some(unit) = unit.as_ref().filter(|unit| unit.dimension != self.kind.dimension) {
                        report_dimension(unit, &place, self.kind.dimension, self.diagnostics);
                    }
                    units[0] = unit;
                }
                "factor" => units[1] = parse_unit(text, &place, 0, self.diagnostics),
                name => {
                    let message = format!("`{name}` has no unit");
                    self.error(&code::TABLE_COLUMN, &header.range, message, &format!("`{name}`"));
                }
            }
        }
        let first = headers.first().map_or(0..0, |header| header.range.clone());
        for (column, name) in [(columns.from, "from"), (columns.to, "to")] {
            if column.is_none() {
                let message = format!("the table has no column `{name}`");
                self.error(&code::TABLE_COLUMN, &first, message, "the headers `name,from,to,value`");
            }
        }
        // What is missing may be the column that nobody recognises.
        if columns.value.is_none() && columns.parameter.is_none() && !is_misspelt {
            let message = "the table has neither a column `value` nor one `parameter`";
            self.error(&code::TABLE_COLUMN, &first, message, "the headers `name,from,to,value`");
        }
        (self.diagnostics.errors() == before).then_some((columns, units))
    }

    /// A row; nothing after an error.
    fn row(
        &mut self,
        table: &Table,
        columns: &Columns,
        units: &[Option<Unit>; 2],
        cells: &[Range<usize>],
        problems: &mut Problems,
    ) -> Option<Row> {
        let whole = cells.first()?.start..cells.last()?.end;
        // A row has as many cells as the line of headers.
        let cell = |column: Option<usize>| column.and_then(|column| Some((column, cells.get(column)?.clone())));
        let filled = |column: Option<usize>| {
            cell(column).map(|(_, range)| (table.text(&range).into_owned(), range)).filter(|(text, _)| !text.is_empty())
        };
        let mut ends = [None, None];
        for ((column, what), end) in [(columns.from, "from"), (columns.to, "to")].into_iter().zip(&mut ends) {
            *end = filled(column).map(|(text, range)| (text, self.place(&range)));
            if let (None, Some((_, range))) = (&end, cell(column)) {
                let range = if range.is_empty() { whole.clone() } else { range };
                let message = format!("the `{what}` of this row is empty");
                self.error(&code::TABLE_CELL, &range, message, "the name of a node");
            }
        }
        let mut number = |column: Option<usize>, unit: &Option<Unit>| {
            let (column, range) = cell(column)?;
            let number = table.number(column, &range, problems)?;
            Some((unit.as_ref().map_or(number, |unit| unit.difference_to_si(number)), range))
        };
        // What a cell that is filled holds no number of has been reported.
        let (has_value, has_factor) = (filled(columns.value).is_some(), filled(columns.factor).is_some());
        let value = number(columns.value, &units[0]);
        let factor = number(columns.factor, &units[1]);
        let expected = "a `value`, or a `parameter` and perhaps its `factor`";
        let (node, range) = match (has_value, filled(columns.parameter)) {
            (true, Some((_, range))) => {
                let message = "this row has a `value` and a `parameter`";
                self.error(&code::TABLE_CELL, &range, message, "one of the two");
                return None;
            }
            (false, None) => {
                let message = format!("this row has no {}", self.kind.value.replace('_', " "));
                self.error(&code::TABLE_CELL, &whole, message, expected);
                return None;
            }
            (true, None) => {
                if let Some((_, range)) = cell(columns.factor).filter(|_| has_factor) {
                    let message = "this row has a `factor` without a `parameter`";
                    self.error(&code::TABLE_CELL, &range, message, expected);
                    return None;
                }
                let (value, range) = value?;
                (Value::Number(Number::Float(value)), range)
            }
            (false, Some((parameter, range))) => {
                let place = self.place(&range);
                if !check_symbol(&parameter, &place, self.diagnostics) || (has_factor && factor.is_none()) {
                    return None;
                }
                (Value::String(product(&parameter, factor.map_or(1.0, |(factor, _)| factor))), range)
            }
        };
        let [Some(from), Some(to)] = ends else { return None };
        let name = filled(columns.name).map(|(text, range)| (text, self.place(&range)));
        Some(Row {
            name,
            ends: [from, to],
            value: Node { value: node, place: self.place(&range) },
            place: self.place(&whole),
        })
    }

    /// The rows as entries of the model's object. Stated names come first, so that no made one takes theirs.
    fn entries(&mut self, rows: Vec<Row>) -> Vec<Entry> {
        for (name, place) in rows.iter().filter_map(|row| row.name.as_ref()) {
            if let Some(first) = self.names.get(name) {
                let message = format!("`{name}` is the name of two {}", self.kind.member);
                let diagnostic = Diagnostic::error(&code::DUPLICATE_KEY, place, message).expected("another name");
                self.diagnostics.push(diagnostic.related(first, "the first one"));
            } else {
                self.names.insert(name.clone(), place.clone());
            }
        }
        let mut made: HashMap<String, usize> = HashMap::new();
        rows.into_iter()
            .map(|row| {
                let Row { name, ends, value, place } = row;
                let (key, key_place) = name.unwrap_or_else(|| (self.name_of(&ends, &mut made), ends[0].1.clone()));
                let between = ends.map(|(text, place)| Node { value: Value::String(text), place }).to_vec();
                let fields = [("between", Node { value: Value::Array(between), place: place.clone() })]
                    .into_iter()
                    .chain([(self.kind.value, value)])
                    .map(|(key, node)| Entry { key: key.to_owned(), key_place: node.place.clone(), node })
                    .collect();
                Entry { key, key_place, node: Node { value: Value::Object(fields), place } }
            })
            .collect()
    }

    /// A name for a coupling between two nodes that none has yet: `a-b`, `a-b 2`, ...
    fn name_of(&mut self, [from, to]: &[(String, Place); 2], made: &mut HashMap<String, usize>) -> String {
        let pair = format!("{}-{}", from.0, to.0);
        let count = made.entry(pair.clone()).or_default();
        loop {
            *count += 1;
            let name = if *count == 1 { pair.clone() } else { format!("{pair} {count}") };
            if !self.names.contains_key(&name) {
                self.names.insert(name.clone(), from.1.clone());
                return name;
            }
        }
    }
}

/// A parameter times a number, as an expression.
pub fn product(parameter: &str, factor: f64) -> String {
    // A number of a file that was read is finite.
    let text = canonical::float(factor).unwrap_or_default();
    if factor == 1.0 {
        parameter.to_owned()
    } else if factor < 0.0 {
        format!("{parameter} * ({text})")
    } else {
        format!("{parameter} * {text}")
    }
}
