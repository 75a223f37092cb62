//! The pattern of a sparse square matrix in compressed columns, and products with it.

use thiserror::Error;

/// A pattern that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("entry {entry} is at row {row}, column {column}, outside a matrix of size {size}")]
pub struct PatternError {
    /// Index of the entry.
    pub entry: usize,
    /// Its row.
    pub row: usize,
    /// Its column.
    pub column: usize,
    /// Rows (and columns) of the matrix.
    pub size: usize,
}

/// Positions of the stored values of a square sparse matrix: compressed columns, rows ascending in each.
///
/// Built from entries (row, column), several of which may fall on one position and then share its value slot.
/// Every diagonal position is stored, so that elimination along the diagonal always finds its pivot's slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    slots: Vec<usize>,
    diagonal: Vec<usize>,
}

impl Pattern {
    /// The pattern of a `size` x `size` matrix with the given (row, column) entries, repeats allowed.
    ///
    /// # Errors
    /// [`PatternError`] for an entry outside the matrix.
    pub fn new(size: usize, entries: &[(usize, usize)]) -> Result<Self, PatternError> {
        for (entry, &(row, column)) in entries.iter().enumerate() {
            if row >= size || column >= size {
                return Err(PatternError { entry, row, column, size });
            }
        }
        let mut order: Vec<(usize, usize, usize)> =
            entries.iter().enumerate().map(|(entry, &(row, column))| (column, row, entry)).collect();
        order.extend((0..size).map(|i| (i, i, usize::MAX)));
        order.sort_unstable();
        let mut pattern = Self {
            column_starts: vec![0; size + 1],
            rows: Vec::with_capacity(order.len()),
            slots: vec![0; entries.len()],
            diagonal: vec![0; size],
        };
        let mut last = None;
        for (column, row, entry) in order {
            if last != Some((column, row)) {
                last = Some((column, row));
                pattern.rows.push(row);
                pattern.column_starts[column + 1] = pattern.rows.len();
            }
            let slot = pattern.rows.len() - 1;
            match pattern.slots.get_mut(entry) {
                Some(place) => *place = slot,
                None => pattern.diagonal[row] = slot,
            }
        }
        Ok(pattern)
    }

    /// Rows (and columns) of the matrix.
    pub fn size(&self) -> usize {
        self.diagonal.len()
    }

    /// Number of stored values.
    pub fn stored(&self) -> usize {
        self.rows.len()
    }

    /// Value slot of each entry given to [`Pattern::new`], in their order.
    pub fn slots(&self) -> &[usize] {
        &self.slots
    }

    /// Value slot of each diagonal position.
    pub fn diagonal(&self) -> &[usize] {
        &self.diagonal
    }

    /// The value slots of a column.
    pub fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.column_starts[column]..self.column_starts[column + 1]
    }

    /// The row of each value slot.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// `product = A x`, values by slot.
    pub fn multiply(&self, values: &[f64], x: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        for (column, x) in x.iter().enumerate() {
            let range = self.column(column);
            for (row, value) in self.rows[range.clone()].iter().zip(&values[range]) {
                product[*row] += value * x;
            }
        }
    }

    /// Neighbours of each index in the graph of A + A', ascending, without loops.
    pub fn symmetric_neighbours(&self) -> Vec<Vec<usize>> {
        let mut neighbours = vec![Vec::new(); self.size()];
        for column in 0..self.size() {
            for &row in &self.rows[self.column(column)] {
                if row != column {
                    neighbours[row].push(column);
                    neighbours[column].push(row);
                }
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        neighbours
    }
}
