//! One dump as columns of numbers and texts.

use crate::DeckError;

/// What a column of a dump holds.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Column {
    /// A quantity of a node: `T12`, `QI12`.
    Node(String, u32),
    /// A conductor: `GL:(1;2)`.
    Pair(String, u32, u32),
}

/// Values of one column, one a row.
#[derive(Debug, Clone)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

/// A dump.
#[derive(Debug)]
pub(super) struct Dump {
    /// `ESATAN 2017 sp2`.
    pub(super) tool: String,
    /// Name of the model.
    pub(super) model: String,
    /// Line of the names of its columns.
    pub(super) header_line: usize,
    /// Line of each row.
    pub(super) lines: Vec<usize>,
    pub(super) times_s: Vec<f64>,
    pub(super) columns: Vec<(Column, Values)>,
}

/// Parses a dump. All its errors are reported at once, one a line.
pub(super) fn parse(file: &str, text: &str) -> Result<Dump, Vec<DeckError>> {
    let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    let fail = |line: usize, message: String| vec![DeckError::at(file, line, message)];
    let title = lines.next().map(|(_, line)| line.trim()).unwrap_or_default();
    if !title.starts_with("ESATAN") {
        return Err(fail(1, "expected a line `ESATAN ...;  MODEL ...;  TIME ...`".to_owned()));
    }
    let mut parts = title.split(';').map(str::trim);
    let tool = parts.next().unwrap_or_default().to_owned();
    let model = parts.find_map(|part| part.strip_prefix("MODEL ")).unwrap_or_default().trim().to_owned();
    let (header_line, header) = lines
        .find(|(_, line)| !line.trim().is_empty())
        .filter(|(_, line)| line.starts_with("TIME,"))
        .ok_or_else(|| fail(2, "expected the names of columns below, `TIME,T1,...`".to_owned()))?;
    let mut names = split(header).map_err(|message| fail(header_line, message))?;
    drop_last_if_empty(&mut names);
    let mut seen = std::collections::HashSet::new();
    let mut columns = Vec::with_capacity(names.len());
    for (position, name) in names.iter().enumerate().skip(1) {
        let column =
            column_of(name).map_err(|message| fail(header_line, format!("column {}: {message}", position + 1)))?;
        if !seen.insert(column.clone()) {
            return Err(fail(header_line, format!("column {}: `{name}` occurs twice", position + 1)));
        }
        let values = if is_text(&column) { Values::Texts(Vec::new()) } else { Values::Numbers(Vec::new()) };
        columns.push((column, values));
    }
    let mut dump = Dump { tool, model, header_line, lines: Vec::new(), times_s: Vec::new(), columns };
    let mut errors = Vec::new();
    for (line, row) in lines.filter(|(_, row)| !row.trim().is_empty()) {
        if let Err(message) = add_row(&mut dump, row, line) {
            errors.push(DeckError::at(file, line, message));
        }
    }
    if dump.lines.is_empty() && errors.is_empty() {
        errors.push(DeckError::at(file, header_line, "there is no row below the names of columns".to_owned()));
    }
    if errors.is_empty() { Ok(dump) } else { Err(errors) }
}

fn add_row(dump: &mut Dump, row: &str, line: usize) -> Result<(), String> {
    let mut cells = split(row)?;
    let expected = dump.columns.len() + 1;
    if cells.len() > expected {
        drop_last_if_empty(&mut cells);
    }
    if cells.len() != expected {
        return Err(format!("{} cells below {expected} names of columns", cells.len()));
    }
    let mut cells = cells.into_iter();
    let time = number(&cells.next().unwrap_or_default()).map_err(|message| format!("TIME: {message}"))?;
    for ((column, values), cell) in dump.columns.iter_mut().zip(cells) {
        match values {
            Values::Numbers(numbers) => {
                numbers.push(number(&cell).map_err(|message| format!("{}: {message}", described(column)))?);
            }
            Values::Texts(texts) => texts.push(cell),
        }
    }
    dump.times_s.push(time);
    dump.lines.push(line);
    Ok(())
}

/// A column's name as the dump writes it.
pub(super) fn described(column: &Column) -> String {
    match column {
        Column::Node(quantity, node) => format!("{quantity}{node}"),
        Column::Pair(kind, from, to) => format!("{kind}:({from};{to})"),
    }
}

fn is_text(column: &Column) -> bool {
    matches!(column, Column::Node(quantity, _) if quantity == "L")
}

/// Cells of a line; quoted ones may hold commas.
fn split(line: &str) -> Result<Vec<String>, String> {
    let mut cells = Vec::new();
    let mut cell = String::new();
    let mut is_quoted = false;
    for character in line.chars() {
        match character {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell).trim().to_owned()),
            _ => cell.push(character),
        }
    }
    if is_quoted {
        return Err("a quoted text does not end".to_owned());
    }
    cells.push(cell.trim().to_owned());
    Ok(cells)
}

/// Lines of dumps may end with a comma.
fn drop_last_if_empty(cells: &mut Vec<String>) {
    if cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
}

fn column_of(name: &str) -> Result<Column, String> {
    let expected = || format!("`{name}` is neither a node's quantity such as `T12` nor a pair such as `GL:(1;2)`");
    if let Some((kind, pair)) = name.split_once(':') {
        let pair = pair.strip_prefix('(').and_then(|pair| pair.strip_suffix(')')).ok_or_else(expected)?;
        let (from, to) = pair.split_once(';').ok_or_else(expected)?;
        let node = |text: &str| text.trim().parse::<u32>().map_err(|_| expected());
        return Ok(Column::Pair(kind.trim().to_owned(), node(from)?, node(to)?));
    }
    let start = name.find(|c: char| c.is_ascii_digit()).ok_or_else(expected)?;
    let (quantity, node) = name.split_at(start);
    if quantity.is_empty() || !quantity.chars().all(|c| c.is_ascii_uppercase()) {
        return Err(expected());
    }
    Ok(Column::Node(quantity.to_owned(), node.parse().map_err(|_| expected())?))
}

fn number(cell: &str) -> Result<f64, String> {
    match cell.replace(['D', 'd'], "E").parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{cell}` is not a finite number")),
    }
}
