//! Stationary covariances with a length in each input (automatic relevance determination).
//!
//! With `q = sum_m ((x_m - x'_m) / l_m)^2`: squared exponential `v exp(-q / 2)` (Rasmussen & Williams 2006, eq. 4.9 and 5.1),
//! Matern 5/2 `v (1 + s + s^2 / 3) exp(-s)`, `s = sqrt(5 q)` (eq. 4.17).

use crate::math::functions::exp;

/// Covariance of the smooth part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// Infinitely smooth.
    SquaredExponential,
    /// Twice differentiable.
    #[serde(rename = "matern-5/2")]
    Matern52,
}

impl Kernel {
    /// Correlation at a squared distance in lengths, and its slope with `ln l_m` divided by the part of that distance that
    /// input `m` has.
    #[inline]
    pub fn correlation(self, square: f64) -> (f64, f64) {
        match self {
            Self::SquaredExponential => {
                let value = exp(-0.5 * square);
                (value, value)
            }
            Self::Matern52 => {
                let s = (5.0 * square).sqrt();
                let decay = exp(-s);
                ((1.0 + s + s * s / 3.0) * decay, 5.0 / 3.0 * (1.0 + s) * decay)
            }
        }
    }

    /// Correlation of two points.
    pub fn between(self, a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
        self.correlation(distance_square(a, b, lengths)).0
    }
}

/// Squared distance of two points in lengths.
pub fn distance_square(a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
    let mut square = 0.0;
    for ((a, b), length) in a.iter().zip(b).zip(lengths) {
        let part = (a - b) / length;
        square += part * part;
    }
    square
}
