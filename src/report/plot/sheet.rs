//! The numbers behind a drawing, recorded while it is drawn: the CSV file beside it, and the values that a page shows at its places.

use std::sync::Arc;

use crate::report::csv;
use crate::report::number::as_given;

/// Most bytes of the values that a page shows; of more places an even choice is shown.
pub const MOST_BYTES: usize = 16 << 10;

/// What stands in a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// Nothing.
    Empty,
    /// A name.
    Text(Arc<str>),
    /// A number; none where it is not finite.
    Number(f64),
}

impl From<f64> for Entry {
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Number(value) } else { Self::Empty }
    }
}

impl From<&str> for Entry {
    fn from(text: &str) -> Self {
        if text.is_empty() { Self::Empty } else { Self::Text(text.into()) }
    }
}

impl Entry {
    /// A mark that stands or is left out.
    pub(super) fn mark(text: &str, stands: bool) -> Self {
        if stands { text.into() } else { Self::Empty }
    }

    fn csv(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) => csv::text(text),
            Self::Number(value) => csv::number(*value),
        }
    }

    fn shown(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) => in_line(text),
            Self::Number(value) => as_given(*value),
        }
    }
}

/// The numbers of a drawing under way.
#[derive(Debug, Default)]
pub struct Sheet {
    columns: Vec<String>,
    rows: Vec<Vec<Entry>>,
    /// Where on the canvas a row is seen; a row may be seen at several places, or at none.
    places: Vec<((i32, i32), usize)>,
}

impl Sheet {
    /// Names the columns.
    pub fn name<T: Into<String>>(&mut self, columns: impl IntoIterator<Item = T>) {
        self.columns = columns.into_iter().map(Into::into).collect();
    }

    /// Adds a row; gives its number.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Entry>) -> usize {
        self.rows.push(cells.into_iter().collect());
        self.rows.len() - 1
    }

    /// Says where a row is seen.
    pub fn place(&mut self, at: (i32, i32), row: usize) {
        self.places.push((at, row));
    }

    /// Columns that hold something.
    fn used(&self) -> Vec<usize> {
        let holds =
            |column: &usize| self.rows.iter().any(|row| row.get(*column).is_some_and(|own| *own != Entry::Empty));
        (0..self.columns.len()).filter(holds).collect()
    }

    /// The numbers as they are kept.
    pub fn finish(self) -> Numbers {
        let used = self.used();
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let cell = |row: &[Entry], column: usize| row.get(column).map(Entry::csv).unwrap_or_default();
        let mut table = line(used.iter().map(|&column| csv::text(&self.columns[column])).collect());
        for row in &self.rows {
            table += &line(used.iter().map(|&column| cell(row, column)).collect());
        }
        Numbers { csv: table, values: self.values(&used) }
    }

    fn values(&self, used: &[usize]) -> String {
        let of_place = |((x, y), row): &((i32, i32), usize)| {
            let cells = self.rows.get(*row).map(Vec::as_slice).unwrap_or_default();
            let shown = used.iter().map(|&column| cells.get(column).map(Entry::shown).unwrap_or_default());
            format!("\n{x} {y}\t{}", shown.collect::<Vec<_>>().join("\t"))
        };
        let lines: Vec<String> = self.places.iter().map(of_place).collect();
        let every = lines.iter().map(String::len).sum::<usize>().div_ceil(MOST_BYTES).max(1);
        let heading: Vec<String> = used.iter().map(|&column| in_line(&self.columns[column])).collect();
        if lines.is_empty() {
            return String::new();
        }
        heading.join("\t") + &lines.into_iter().step_by(every).collect::<String>()
    }
}

/// A text without what separates cells and lines.
fn in_line(text: &str) -> String {
    text.replace(['\t', '\n', '\r'], " ")
}

/// The numbers behind a drawing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Numbers {
    /// All of them as CSV, in full.
    pub csv: String,
    /// What is shown where: a line of headings between tabs, then lines of `x y` in pixels of the canvas and the values, in up to six
    /// digits. Empty where nothing has a place.
    pub values: String,
}
