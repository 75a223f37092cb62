//! Information where predictions are linear and all is normal: `z = A u + B v + e`, `u`, `v`, `e` standard normal.
//!
//! `U = 1/2 ln det(I + A A' + B B') - 1/2 ln det(I + B B')` for learning `u` with `v` a nuisance. Exact there (Lindley
//! 1956); elsewhere, with derivatives at nominal parameters times prior standard deviations, an estimate for screening.

use crate::math::cholesky::{self, NotPositiveDefinite};

/// Information about the first `learn` columns of `jacobian` (`readings x unknowns`, row by row, each row divided by the
/// noise's standard deviation, each column times the prior's), nats.
///
/// # Errors
/// [`NotPositiveDefinite`] where an entry is not finite.
pub fn information(jacobian: &[f64], unknowns: usize, learn: usize) -> Result<f64, NotPositiveDefinite> {
    let all = log_determinant(jacobian, unknowns, 0)?;
    let nuisance = log_determinant(jacobian, unknowns, learn)?;
    Ok((0.5 * (all - nuisance)).max(0.0))
}

/// `ln det(I + J J')` over the columns from `first` on.
fn log_determinant(jacobian: &[f64], unknowns: usize, first: usize) -> Result<f64, NotPositiveDefinite> {
    if unknowns == 0 || first >= unknowns {
        return Ok(0.0);
    }
    let rows: Vec<&[f64]> = jacobian.chunks_exact(unknowns).map(|row| &row[first..]).collect();
    let n = rows.len();
    let mut matrix = vec![0.0; n * n];
    for a in 0..n {
        for b in 0..=a {
            let product: f64 = rows[a].iter().zip(rows[b]).map(|(x, y)| x * y).sum();
            matrix[a * n + b] = product + f64::from(u8::from(a == b));
        }
    }
    cholesky::factor(&mut matrix, n)?;
    Ok(cholesky::log_determinant(&matrix, n))
}

/// Divergence of a normal posterior from the standard normal prior for the first `learn` of `n` unknowns:
/// `1/2 (tr C + m' m - k - ln det C)`, from the factor of the posterior's precision and its mean. Averaged over data it
/// is the Laplace estimate of the information (Long, Scavino, Tempone & Wang 2013, Comput. Methods Appl. Mech. Eng. 259,
/// 24).
///
/// # Errors
/// [`NotPositiveDefinite`] where the covariance is singular.
pub fn divergence(precision_factor: &[f64], mean: &[f64], learn: usize) -> Result<f64, NotPositiveDefinite> {
    let n = mean.len();
    let covariance = cholesky::inverse(precision_factor, n);
    let mut learned_covariance = vec![0.0; learn * learn];
    let mut sum = -(learn as f64);
    for a in 0..learn {
        learned_covariance[a * learn..(a + 1) * learn].copy_from_slice(&covariance[a * n..a * n + learn]);
        sum += covariance[a * n + a] + mean[a] * mean[a];
    }
    cholesky::factor(&mut learned_covariance, learn)?;
    Ok(0.5 * (sum - cholesky::log_determinant(&learned_covariance, learn)))
}
