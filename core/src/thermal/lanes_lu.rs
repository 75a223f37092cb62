//! Dense LU factors in lanes: several small matrices eliminated side by side, each with its own row exchanges, with
//! the bits that each would have alone.

use crate::expression::Lanes;

/// Factors of a square matrix per lane, rows exchanged for the largest pivot.
#[derive(Clone, Debug)]
pub(super) struct LanesLu<V> {
    size: usize,
    /// Row by row: on entry the matrix, after [`LanesLu::factor`] its factors.
    pub matrix: Vec<V>,
    /// Row exchanged with row `k`, for each step and lane.
    pivots: Vec<usize>,
}

impl<V: Lanes> LanesLu<V> {
    pub fn new(size: usize) -> Self {
        Self { size, matrix: vec![V::splat(0.0); size * size], pivots: vec![0; size * V::COUNT] }
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
                let factor = row[k].zip(pivot, |a, b| a / b);
                row[k] = factor;
                for (value, &upper) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                    let product = factor.zip(upper, |a, b| a * b);
                    *value = value.zip(product, |a, b| a - b);
                }
            }
        }
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
            let mut value = rhs[row];
            for (&factor, &x) in self.matrix[row * n..row * n + row].iter().zip(rhs.iter()) {
                let product = factor.zip(x, |a, b| a * b);
                value = value.zip(product, |a, b| a - b);
            }
            rhs[row] = value;
        }
        for row in (0..n).rev() {
            let mut value = rhs[row];
            for (&factor, &x) in self.matrix[row * n + row + 1..(row + 1) * n].iter().zip(&rhs[row + 1..]) {
                let product = factor.zip(x, |a, b| a * b);
                value = value.zip(product, |a, b| a - b);
            }
            rhs[row] = value.zip(self.matrix[row * n + row], |a, b| a / b);
        }
    }

    /// Replaces `rhs` by the solution with the transposed matrix.
    pub fn solve_transposed(&self, rhs: &mut [V]) {
        let n = self.size;
        for row in 0..n {
            let value = rhs[row].zip(self.matrix[row * n + row], |a, b| a / b);
            rhs[row] = value;
            for column in row + 1..n {
                let product = self.matrix[row * n + column].zip(value, |a, b| a * b);
                rhs[column] = rhs[column].zip(product, |a, b| a - b);
            }
        }
        for row in (1..n).rev() {
            let value = rhs[row];
            for column in 0..row {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Four matrices that need different row exchanges, side by side and alone.
    #[test]
    fn each_lane_has_the_bits_it_has_alone_and_solves_its_system() {
        let size = 5;
        let value = |lane: usize, row: usize, column: usize| {
            let mixed = (lane * 31 + row * 17 + column * 7) % 13;
            if (row + lane) % size == column { 20.0 } else { mixed as f64 - 6.0 }
        };
        let mut lanes = LanesLu::<[f64; 4]>::new(size);
        let mut rhs = vec![[0.0; 4]; size];
        let mut transposed = rhs.clone();
        for row in 0..size {
            for column in 0..size {
                lanes.matrix[row * size + column] = std::array::from_fn(|lane| value(lane, row, column));
            }
            // The right-hand sides of the solution 1, 2, ..., 5.
            rhs[row] = std::array::from_fn(|lane| (0..size).map(|c| value(lane, row, c) * (c + 1) as f64).sum());
            transposed[row] = std::array::from_fn(|lane| (0..size).map(|c| value(lane, c, row) * (c + 1) as f64).sum());
        }
        let (given, given_transposed) = (rhs.clone(), transposed.clone());
        lanes.factor();
        lanes.solve(&mut rhs);
        lanes.solve_transposed(&mut transposed);
        for lane in 0..4 {
            let mut alone = LanesLu::<f64>::new(size);
            for row in 0..size {
                for column in 0..size {
                    alone.matrix[row * size + column] = value(lane, row, column);
                }
            }
            alone.factor();
            let mut x: Vec<f64> = given.iter().map(|v| v[lane]).collect();
            let mut y: Vec<f64> = given_transposed.iter().map(|v| v[lane]).collect();
            alone.solve(&mut x);
            alone.solve_transposed(&mut y);
            for row in 0..size {
                assert_eq!(x[row].to_bits(), rhs[row][lane].to_bits());
                assert_eq!(y[row].to_bits(), transposed[row][lane].to_bits());
                // Entries below 21, conditions below some hundred: 1e-12 leaves room.
                assert!((x[row] - (row + 1) as f64).abs() < 1e-12, "{x:?}");
                assert!((y[row] - (row + 1) as f64).abs() < 1e-12, "{y:?}");
            }
        }
    }
}
