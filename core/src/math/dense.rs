//! LU factorisation with partial pivoting of small dense matrices, in place and without allocation.
//!
//! `P A = L U` with unit lower `L` (Golub & Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1, right-looking).
//! A matrix is a flat slice, row after row: element (i, j) of an n x n matrix is `matrix[i * n + j]`.

use thiserror::Error;

use super::lanes::dot;

/// A pivot of a factorisation that is zero or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the matrix is singular: column {column} has the pivot {pivot}, which is not a finite number other than 0")]
pub struct SingularError {
    /// Column of the matrix (as the caller numbers it) where elimination stopped.
    pub column: usize,
    /// The pivot found there.
    pub pivot: f64,
}

/// An n x n matrix of its elements (i, j).
pub fn square(n: usize, mut element: impl FnMut(usize, usize) -> f64) -> Vec<f64> {
    let mut matrix = Vec::with_capacity(n * n);
    for i in 0..n {
        matrix.extend((0..n).map(|j| element(i, j)));
    }
    matrix
}

/// Replaces an n x n matrix by its factors; `pivots` (length n, which sets n) takes the row exchanged with row k at step k.
///
/// The strict lower triangle then holds `L` (unit diagonal left out), the rest `U`. Cost: 2 n^3 / 3 operations.
///
/// # Errors
/// [`SingularError`] when a column holds no usable pivot; the contents of `matrix` are then undefined.
pub fn factor(matrix: &mut [f64], pivots: &mut [usize]) -> Result<(), SingularError> {
    let n = pivots.len();
    debug_assert_eq!(matrix.len(), n * n);
    for k in 0..n {
        let mut row = k;
        let mut largest = matrix[k * n + k].abs();
        for i in k + 1..n {
            let size = matrix[i * n + k].abs();
            // A NaN wins, so that it is reported here and not carried on.
            if size > largest || size.is_nan() {
                largest = size;
                row = i;
            }
        }
        pivots[k] = row;
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(SingularError { column: k, pivot: matrix[row * n + k] });
        }
        let (upper, below) = matrix.split_at_mut((k + 1) * n);
        let pivot_row = &mut upper[k * n..];
        if row != k {
            pivot_row.swap_with_slice(&mut below[(row - k - 1) * n..(row - k) * n]);
        }
        let reciprocal = 1.0 / pivot_row[k];
        let tail = &pivot_row[k + 1..];
        for line in below.chunks_exact_mut(n) {
            let multiplier = line[k] * reciprocal;
            line[k] = multiplier;
            for (x, u) in line[k + 1..].iter_mut().zip(tail) {
                *x -= multiplier * u;
            }
        }
    }
    Ok(())
}

/// Solves `A x = b` in place from the factors of [`factor`]; `rhs` holds b on entry and x on return. Cost: 2 n^2.
pub fn solve(factors: &[f64], pivots: &[usize], rhs: &mut [f64]) {
    let n = pivots.len();
    debug_assert!(factors.len() == n * n && rhs.len() == n);
    for (k, &row) in pivots.iter().enumerate() {
        rhs.swap(k, row);
    }
    for (i, line) in factors.chunks_exact(n.max(1)).enumerate() {
        let (solved, rest) = rhs.split_at_mut(i);
        rest[0] -= dot(&line[..i], solved);
    }
    for (i, line) in factors.chunks_exact(n.max(1)).enumerate().rev() {
        let (rest, solved) = rhs.split_at_mut(i + 1);
        rest[i] = (rest[i] - dot(&line[i + 1..], solved)) / line[i];
    }
}

/// Solves `A' x = b` (the transposed system) in place from the factors of [`factor`]. Cost: 2 n^2.
pub fn solve_transposed(factors: &[f64], pivots: &[usize], rhs: &mut [f64]) {
    let n = pivots.len();
    debug_assert!(factors.len() == n * n && rhs.len() == n);
    for (i, line) in factors.chunks_exact(n.max(1)).enumerate() {
        let (done, rest) = rhs.split_at_mut(i + 1);
        let x = done[i] / line[i];
        done[i] = x;
        for (r, u) in rest.iter_mut().zip(&line[i + 1..]) {
            *r -= u * x;
        }
    }
    for (i, line) in factors.chunks_exact(n.max(1)).enumerate().rev() {
        let (rest, done) = rhs.split_at_mut(i);
        let x = done[0];
        for (r, l) in rest.iter_mut().zip(&line[..i]) {
            *r -= l * x;
        }
    }
    for (k, &row) in pivots.iter().enumerate().rev() {
        rhs.swap(k, row);
    }
}

/// Scalar product of short vectors, summed in the order of their entries.
#[inline]
pub fn dot_in_order(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (x, y) in a.iter().zip(b) {
        sum += x * y;
    }
    sum
}

/// Scalar product of long columns by eight interleaved sums, then their sum in order: the same bits everywhere, and no wait
/// for the sum before.
#[inline]
pub fn dot_of_columns(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (blocks_a, blocks_b) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (x, y) in blocks_a.0.iter().zip(blocks_b.0) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    for (lane, (x, y)) in blocks_a.1.iter().zip(blocks_b.1).enumerate() {
        sums[lane] += x * y;
    }
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))
}
