//! Cholesky factors `A = L L'` of small dense symmetric matrices, in place and without allocation.
//!
//! A matrix is a flat slice, row after row. The factor fills the lower triangle; what lies above it is not read.

use thiserror::Error;

use crate::math::functions::ln;

/// A matrix that is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the matrix is not positive definite: the pivot {index} is {pivot}")]
pub struct NotPositiveDefinite {
    /// Place of the pivot.
    pub index: usize,
    /// Its value.
    pub pivot: f64,
}

/// Replaces the lower triangle of an n x n matrix by its factor. Cost: n^3 / 3 operations.
///
/// # Errors
/// [`NotPositiveDefinite`] at the first pivot that is not a finite number above 0.
pub fn factor(matrix: &mut [f64], n: usize) -> Result<(), NotPositiveDefinite> {
    for j in 0..n {
        for i in j..n {
            let mut sum = matrix[i * n + j];
            for k in 0..j {
                sum -= matrix[i * n + k] * matrix[j * n + k];
            }
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return Err(NotPositiveDefinite { index: j, pivot: sum });
                }
                matrix[j * n + j] = sum.sqrt();
            } else {
                matrix[i * n + j] = sum / matrix[j * n + j];
            }
        }
    }
    Ok(())
}

/// `product = L x`.
#[inline]
pub fn multiply(factor: &[f64], x: &[f64], product: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let mut sum = 0.0;
        for k in 0..=i {
            sum += factor[i * n + k] * x[k];
        }
        product[i] = sum;
    }
}

/// Solves `L x = b` in place.
#[inline]
pub fn solve_lower(factor: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let mut sum = x[i];
        for k in 0..i {
            sum -= factor[i * n + k] * x[k];
        }
        x[i] = sum / factor[i * n + i];
    }
}

/// Solves `L' x = b` in place.
#[inline]
pub fn solve_lower_transposed(factor: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in i + 1..n {
            sum -= factor[k * n + i] * x[k];
        }
        x[i] = sum / factor[i * n + i];
    }
}

/// Solves `A x = b` in place, from the factor of `A`.
pub fn solve(factor: &[f64], x: &mut [f64]) {
    solve_lower(factor, x);
    solve_lower_transposed(factor, x);
}

/// `ln det A` from the factor.
pub fn log_determinant(factor: &[f64], n: usize) -> f64 {
    (0..n).map(|i| 2.0 * ln(factor[i * n + i])).sum()
}

/// The inverse of `A` (full, symmetric) from the factor.
pub fn inverse(factor: &[f64], n: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; n * n];
    let mut column = vec![0.0; n];
    for j in 0..n {
        column.fill(0.0);
        column[j] = 1.0;
        solve(factor, &mut column);
        for i in 0..n {
            inverse[i * n + j] = column[i];
        }
    }
    inverse
}
