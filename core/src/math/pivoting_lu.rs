//! Sparse LU with threshold partial pivoting, column by column (Gilbert & Peierls 1988, SIAM J. Sci. Stat. Comput. 9, 862).
//!
//! Each column solves a triangular system with the columns of `L` so far; a depth-first search finds which of them take
//! part. Allocates as it goes: the way out when pivots along the diagonal will not do.

use super::dense::SingularError;
use super::sparse::Pattern;

/// The diagonal is taken as pivot when it is at least this share of the column's largest entry.
const DIAGONAL_SHARE: f64 = 0.1;

const NONE: usize = usize::MAX;

/// Columns of a triangular factor: (row, value) pairs.
#[derive(Clone, Debug, Default)]
struct Columns {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Columns {
    fn column(&self, k: usize) -> impl DoubleEndedIterator<Item = (usize, f64)> + '_ {
        let range = self.starts[k]..self.starts[k + 1];
        self.rows[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    fn push(&mut self, row: usize, value: f64) {
        self.rows.push(row);
        self.values.push(value);
    }
}

/// Factors `A(:, order) = L U` with rows exchanged for size.
#[derive(Clone, Debug)]
pub(super) struct PivotingLu {
    /// Rows by original index; unit diagonal left out.
    lower: Columns,
    /// Rows by step; diagonal apart.
    upper: Columns,
    diagonal: Vec<f64>,
    /// Original column of each step.
    order: Vec<usize>,
    /// Original row that is the pivot of each step.
    pivot_rows: Vec<usize>,
}

impl PivotingLu {
    /// Factorises the matrix of the given pattern and values, columns taken in the given order.
    ///
    /// # Errors
    /// [`SingularError`] with the original column in which no pivot was found.
    pub fn new(pattern: &Pattern, values: &[f64], order: &[usize]) -> Result<Self, SingularError> {
        let size = order.len();
        let mut lower = Columns { starts: vec![0], ..Columns::default() };
        let mut upper = lower.clone();
        let (mut diagonal, mut pivot_rows) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let mut step_of_row = vec![NONE; size];
        let mut x = vec![0.0; size];
        let mut mark = vec![NONE; size];
        let mut reached: Vec<usize> = Vec::new();
        let mut stack: Vec<(usize, usize)> = Vec::new();
        for (step, &column) in order.iter().enumerate() {
            reached.clear();
            for slot in pattern.column(column) {
                let row = pattern.rows()[slot];
                if mark[row] != step {
                    mark[row] = step;
                    stack.push((row, 0));
                }
                while let Some((row, next)) = stack.pop() {
                    let below = match step_of_row[row] {
                        NONE => None,
                        k => (lower.starts[k] + next..lower.starts[k + 1]).next().map(|at| lower.rows[at]),
                    };
                    match below {
                        Some(below) => {
                            stack.push((row, next + 1));
                            if mark[below] != step {
                                mark[below] = step;
                                stack.push((below, 0));
                            }
                        }
                        None => reached.push(row),
                    }
                }
            }
            for slot in pattern.column(column) {
                x[pattern.rows()[slot]] = values[slot];
            }
            // Reversed postorder is an order in which every column comes before those it changes.
            for &row in reached.iter().rev() {
                let k = step_of_row[row];
                if k != NONE {
                    let factor = x[row];
                    upper.push(k, factor);
                    for (i, l) in lower.column(k) {
                        x[i] -= l * factor;
                    }
                }
            }
            let candidates = || reached.iter().copied().filter(|&row| step_of_row[row] == NONE);
            let mut pivot_row = column;
            let mut largest = 0.0;
            for row in candidates() {
                if x[row].abs() > largest || x[row].is_nan() {
                    (largest, pivot_row) = (x[row].abs(), row);
                }
            }
            if !(largest > 0.0 && largest.is_finite()) {
                let pivot = if largest == 0.0 { 0.0 } else { x[pivot_row] };
                return Err(SingularError { column, pivot });
            }
            if step_of_row[column] == NONE && mark[column] == step && x[column].abs() >= DIAGONAL_SHARE * largest {
                pivot_row = column;
            }
            let pivot = x[pivot_row];
            for row in candidates().filter(|&row| row != pivot_row) {
                lower.push(row, x[row] / pivot);
            }
            step_of_row[pivot_row] = step;
            pivot_rows.push(pivot_row);
            diagonal.push(pivot);
            lower.starts.push(lower.rows.len());
            upper.starts.push(upper.rows.len());
            for &row in &reached {
                x[row] = 0.0;
            }
        }
        Ok(Self { lower, upper, diagonal, order: order.to_vec(), pivot_rows })
    }

    /// Solves `A x = b` in place; `work` is as long as the right-hand side.
    pub fn solve(&self, rhs: &mut [f64], work: &mut [f64]) {
        for (k, &row) in self.pivot_rows.iter().enumerate() {
            let x = rhs[row];
            work[k] = x;
            for (i, l) in self.lower.column(k) {
                rhs[i] -= l * x;
            }
        }
        for (k, &column) in self.order.iter().enumerate().rev() {
            let x = work[k] / self.diagonal[k];
            for (i, u) in self.upper.column(k) {
                work[i] -= u * x;
            }
            rhs[column] = x;
        }
    }

    /// Solves `A' x = b` in place; `work` is as long as the right-hand side.
    pub fn solve_transposed(&self, rhs: &mut [f64], work: &mut [f64]) {
        for (k, &column) in self.order.iter().enumerate() {
            let mut x = rhs[column];
            for (i, u) in self.upper.column(k) {
                x -= u * work[i];
            }
            work[k] = x / self.diagonal[k];
        }
        for (k, &row) in self.pivot_rows.iter().enumerate().rev() {
            let mut x = work[k];
            for (i, l) in self.lower.column(k) {
                x -= l * rhs[i];
            }
            rhs[row] = x;
        }
    }
}
