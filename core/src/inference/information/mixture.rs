//! Importance sampling of an inner integral round a normal (Laplace) approximation of the posterior, with a share of the
//! draws from the prior.
//!
//! Beck, Dia, Espath, Long & Tempone (2018, Comput. Methods Appl. Mech. Eng. 334, 523); the fixed shares with the weights
//! of the whole mixture are those of Owen & Zhou (2000, J. Am. Stat. Assoc. 95, 135): a posterior that is not normal, or
//! has a second mode, then costs draws but gives no wrong answer without a sign of it.

use crate::math::cholesky::{self, NotPositiveDefinite};
use crate::math::functions::{exp, ln, ln_1p};

/// One draw in so many is from the prior.
pub const PRIOR_EVERY: usize = 8;

/// The proposal for unknowns whose prior is standard normal.
#[derive(Clone, Debug)]
pub struct Mixture {
    mean: Vec<f64>,
    /// Factor of the precision.
    factor: Vec<f64>,
    half_log_determinant: f64,
}

impl Mixture {
    /// From predictions linearised at `at`: whitened `jacobian` (`readings x unknowns`) and whitened readings minus
    /// predictions there. Precision `I + J' J`, mean `(I + J' J)^-1 J' (r + J at)`.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] where an entry is not finite.
    pub fn linearised(jacobian: &[f64], residuals: &[f64], at: &[f64]) -> Result<Self, NotPositiveDefinite> {
        let n = at.len();
        let mut factor = vec![0.0; n * n];
        let mut mean = vec![0.0; n];
        for a in 0..n {
            factor[a * n + a] = 1.0;
        }
        for (row, residual) in jacobian.chunks_exact(n.max(1)).zip(residuals) {
            let target = residual + row.iter().zip(at).map(|(j, u)| j * u).sum::<f64>();
            for a in 0..n {
                mean[a] += row[a] * target;
                for b in 0..=a {
                    factor[a * n + b] += row[a] * row[b];
                }
            }
        }
        cholesky::factor(&mut factor, n)?;
        cholesky::solve(&factor, &mut mean);
        let half_log_determinant = 0.5 * cholesky::log_determinant(&factor, n);
        Ok(Self { mean, factor, half_log_determinant })
    }

    /// Mean of the normal approximation.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// The same normal approximation round another point.
    pub fn centred(mut self, at: &[f64]) -> Self {
        self.mean.copy_from_slice(at);
        self
    }

    /// Squared distance of a point from the mean, in standard deviations of the normal approximation.
    pub fn distance_squared(&self, at: &[f64]) -> f64 {
        let n = at.len();
        (0..n)
            .map(|column| {
                let sum: f64 = (column..n).map(|row| self.factor[row * n + column] * (at[row] - self.mean[row])).sum();
                sum * sum
            })
            .sum()
    }

    /// Factor of its precision.
    pub fn precision_factor(&self) -> &[f64] {
        &self.factor
    }

    /// Turns the standard normal numbers in `draw` into draw number `index`.
    pub fn place(&self, index: usize, draw: &mut [f64]) {
        if !index.is_multiple_of(PRIOR_EVERY) {
            cholesky::solve_lower_transposed(&self.factor, draw);
            for (value, mean) in draw.iter_mut().zip(&self.mean) {
                *value += mean;
            }
        }
    }

    /// Logarithm of prior over proposal at a draw, out of `draws`.
    pub fn log_weight(&self, draw: &[f64], draws: usize) -> f64 {
        let of_prior = draws.div_ceil(PRIOR_EVERY) as f64 / draws as f64;
        let square = self.distance_squared(draw);
        let prior = -0.5 * draw.iter().map(|value| value * value).sum::<f64>();
        // ln(p / (a p + (1 - a) q)), by q / p.
        let ratio = self.half_log_determinant - 0.5 * square - prior + ln(1.0 - of_prior) - ln(of_prior);
        if of_prior >= 1.0 {
            return 0.0;
        }
        -ln(of_prior) - if ratio > 0.0 { ratio + ln_1p(exp(-ratio)) } else { ln_1p(exp(ratio)) }
    }
}
