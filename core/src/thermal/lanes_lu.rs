//! Dense LU factors in lanes: several small matrices eliminated side by side, each with its own row exchanges, with
//! the bits that each would have alone.
//!
//! Networks have few conductors a node, so most entries are 0 and stay 0: they are passed over in the elimination, and
//! solutions go through lists of the others.

use crate::math::lanes::{Lanes, subtract_multiple};

/// Factors of a square matrix per lane, rows exchanged for the largest pivot.
#[derive(Clone, Debug)]
pub struct LanesLu<V> {
    size: usize,
    /// Row by row: on entry the matrix, after [`LanesLu::factor`] its factors.
    pub matrix: Vec<V>,
    /// Row exchanged with row `k`, for each step and lane.
    pivots: Vec<usize>,
    /// Columns of the factors' entries that are not 0 in every lane, row by row, without the diagonal.
    pub columns: Vec<u32>,
    /// Where a row's columns left and right of the diagonal begin in `columns`, and one end more.
    bounds: Vec<u32>,
}

impl<V: Lanes> LanesLu<V> {
    /// A matrix of zeros.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            matrix: vec![V::splat(0.0); size * size],
            pivots: vec![0; size * V::COUNT],
            columns: Vec::with_capacity(size * size.saturating_sub(1)),
            bounds: vec![0; 2 * size + 1],
        }
    }

    /// Factors in place. A lane with a singular matrix ends with non-finite numbers.
    pub fn factor(&mut self) {
        let n = self.size;
        for k in 0..n {
            let mut same = true;
            // The common case at once for all lanes: the diagonal is the largest.
            let mut largest = V::splat(0.0);
            for row in k + 1..n {
                largest = largest.zip(self.matrix[row * n + k], |a, b| if b.abs() > a { b.abs() } else { a });
            }
            let kept = (0..V::COUNT).all(|lane| largest.lane(lane) <= self.matrix[k * n + k].lane(lane).abs());
            if kept {
                self.pivots[k * V::COUNT..(k + 1) * V::COUNT].fill(k);
            }
            for lane in (0..V::COUNT).filter(|_| !kept) {
                let mut best = k;
                let mut size = self.matrix[k * n + k].lane(lane).abs();
                for row in k + 1..n {
                    let candidate = self.matrix[row * n + k].lane(lane).abs();
                    if candidate > size {
                        (best, size) = (row, candidate);
                    }
                }
                self.pivots[k * V::COUNT + lane] = best;
                same &= best == self.pivots[k * V::COUNT];
            }
            if !kept {
                self.exchange_rows(k, same);
            }
            let (above, below) = self.matrix.split_at_mut((k + 1) * n);
            let pivot_row = &above[k * n..];
            let pivot = pivot_row[k];
            for row in below.chunks_exact_mut(n) {
                if is_zero(&row[k]) {
                    continue;
                }
                let factor = row[k].zip(pivot, |a, b| a / b);
                row[k] = factor;
                for (value, &upper) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                    let product = factor.zip(upper, |a, b| a * b);
                    *value = value.zip(product, |a, b| a - b);
                }
            }
        }
        self.list_entries();
    }

    /// Lists the factors' entries that are not 0.
    fn list_entries(&mut self) {
        let n = self.size;
        self.columns.clear();
        for (row, entries) in self.matrix.chunks_exact(n.max(1)).enumerate() {
            let (left, right) = entries.split_at(row);
            for (place, (first, part)) in [(0, left), (row + 1, &right[1..])].into_iter().enumerate() {
                self.bounds[2 * row + place] = self.columns.len() as u32;
                let columns = part.iter().enumerate().filter(|(_, entry)| !is_zero(*entry));
                self.columns.extend(columns.map(|(column, _)| (first + column) as u32));
            }
        }
        self.bounds[2 * n] = self.columns.len() as u32;
    }

    /// Columns of a row's entries left (`0`) or right (`1`) of the diagonal.
    fn entries(&self, row: usize, side: usize) -> &[u32] {
        let from = 2 * row + side;
        &self.columns[self.bounds[from] as usize..self.bounds[from + 1] as usize]
    }

    fn exchange_rows(&mut self, k: usize, same: bool) {
        let n = self.size;
        if same {
            let other = self.pivots[k * V::COUNT];
            if other != k {
                for column in 0..n {
                    self.matrix.swap(k * n + column, other * n + column);
                }
            }
            return;
        }
        for lane in 0..V::COUNT {
            let other = self.pivots[k * V::COUNT + lane];
            if other != k {
                for column in 0..n {
                    let (a, b) = (self.matrix[k * n + column].lane(lane), self.matrix[other * n + column].lane(lane));
                    self.matrix[k * n + column].set_lane(lane, b);
                    self.matrix[other * n + column].set_lane(lane, a);
                }
            }
        }
    }

    /// Replaces `rhs` by the solution.
    pub fn solve(&self, rhs: &mut [V]) {
        let n = self.size;
        for k in 0..n {
            let pivots = &self.pivots[k * V::COUNT..(k + 1) * V::COUNT];
            for (lane, &other) in pivots.iter().enumerate() {
                if other != k {
                    let (a, b) = (rhs[k].lane(lane), rhs[other].lane(lane));
                    rhs[k].set_lane(lane, b);
                    rhs[other].set_lane(lane, a);
                }
            }
        }
        for row in 1..n {
            rhs[row] = self.without(row, 0, rhs);
        }
        for row in (0..n).rev() {
            rhs[row] = self.without(row, 1, rhs).zip(self.matrix[row * n + row], |a, b| a / b);
        }
    }

    /// An entry of `rhs` without what the row's entries on one side of the diagonal contribute.
    #[inline]
    fn without(&self, row: usize, side: usize, rhs: &[V]) -> V {
        let factors = &self.matrix[row * self.size..(row + 1) * self.size];
        let mut value = rhs[row];
        for &column in self.entries(row, side) {
            let product = factors[column as usize].zip(rhs[column as usize], |a, b| a * b);
            value = value.zip(product, |a, b| a - b);
        }
        value
    }

    /// Replaces `rhs` by the solution with the transposed matrix.
    pub fn solve_transposed(&self, rhs: &mut [V]) {
        let n = self.size;
        for row in 0..n {
            let value = rhs[row].zip(self.matrix[row * n + row], |a, b| a / b);
            rhs[row] = value;
            for &column in self.entries(row, 1) {
                let column = column as usize;
                let product = self.matrix[row * n + column].zip(value, |a, b| a * b);
                rhs[column] = rhs[column].zip(product, |a, b| a - b);
            }
        }
        for row in (1..n).rev() {
            let value = rhs[row];
            for &column in self.entries(row, 0) {
                let column = column as usize;
                let product = self.matrix[row * n + column].zip(value, |a, b| a * b);
                rhs[column] = rhs[column].zip(product, |a, b| a - b);
            }
        }
        for k in (0..n).rev() {
            for lane in 0..V::COUNT {
                let other = self.pivots[k * V::COUNT + lane];
                if other != k {
                    let (a, b) = (rhs[k].lane(lane), rhs[other].lane(lane));
                    rhs[k].set_lane(lane, b);
                    rhs[other].set_lane(lane, a);
                }
            }
        }
    }
}

impl LanesLu<f64> {
    /// Replaces each of several right-hand sides, `size x columns`, by its solution, with the bits that it would have alone.
    pub fn solve_columns(&self, rhs: &mut [f64], columns: usize) {
        let n = self.size;
        for (k, &other) in self.pivots.iter().enumerate() {
            if other != k {
                let (above, below) = rhs.split_at_mut(other * columns);
                above[k * columns..(k + 1) * columns].swap_with_slice(&mut below[..columns]);
            }
        }
        for row in 1..n {
            let (above, rest) = rhs.split_at_mut(row * columns);
            let row_rhs = &mut rest[..columns];
            for &column in self.entries(row, 0) {
                let column = column as usize;
                subtract_multiple(
                    row_rhs,
                    self.matrix[row * n + column],
                    &above[column * columns..(column + 1) * columns],
                );
            }
        }
        for row in (0..n).rev() {
            let (above, below) = rhs.split_at_mut((row + 1) * columns);
            let row_rhs = &mut above[row * columns..];
            for &column in self.entries(row, 1) {
                let column = column as usize;
                let from = (column - row - 1) * columns;
                subtract_multiple(row_rhs, self.matrix[row * n + column], &below[from..from + columns]);
            }
            let pivot = self.matrix[row * n + row];
            for value in row_rhs {
                *value /= pivot;
            }
        }
    }
}

/// Whether a value is 0 in every lane.
#[inline]
fn is_zero<V: Lanes>(value: &V) -> bool {
    (0..V::COUNT).all(|lane| value.lane(lane) == 0.0)
}
