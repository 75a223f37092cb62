//! The restricted likelihood of a fit under other noise than its own.
//!
//! A fit takes up the slow part of correlated noise rather than the fast one, so that what it leaves looks too white. The restricted
//! likelihood (Patterson & Thompson 1971, Biometrika 58, 545) corrects for that: with the columns `X` of the fit and its errors `e`,
//! whitened by the noise that is tried, it is the likelihood of the errors with `b' A^-1 b / 2 - log |A| / 2` added,
//! `A = X'X`, `b = X'e`: the fit is made anew under that noise, and integrated over.

use crate::diagnosis::noise::estimate::{EstimatedNoise, SensorRows, whiten, whitening};
use crate::math::cholesky;
use crate::math::lanes::dot;

/// Share of a column's square that is added to it: far above rounding, far below what data tell.
const RIDGE: f64 = 1e-12;

/// A fit's columns and errors, by row: readings of open sensors in SI, all else in standard deviations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinearFit {
    /// Of each parameter and effect that the fit left free.
    pub columns: Vec<Vec<f64>>,
    /// What the fit left.
    pub errors: Vec<f64>,
}

impl LinearFit {
    /// What is to be added to the log likelihood of the errors where the sensors have these noises, but for a constant; 0 where a column
    /// is nothing.
    pub fn correction(&self, series: &[SensorRows], noises: &[EstimatedNoise]) -> f64 {
        let k = self.columns.len();
        let filters = whitening(series, noises.iter());
        let whitened = |column: &[f64]| {
            let mut column = column.to_vec();
            whiten(series, &filters, &mut column);
            column
        };
        let errors = whitened(&self.errors);
        let columns: Vec<Vec<f64>> = self.columns.iter().map(|column| whitened(column)).collect();
        let mut matrix = vec![0.0; k * k];
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns[..=i].iter().enumerate() {
                let product = dot(a, b);
                (matrix[i * k + j], matrix[j * k + i]) = (product, product);
            }
        }
        // Columns of very different size would spoil the factor.
        let scales: Vec<f64> = (0..k).map(|i| matrix[i * k + i].sqrt()).collect();
        if scales.iter().any(|scale| !(*scale > 0.0)) {
            return 0.0;
        }
        let mut scaled: Vec<f64> =
            (0..k * k).map(|place| matrix[place] / (scales[place / k] * scales[place % k])).collect();
        // Columns that act only together would have a factor under one noise and none under the next.
        (0..k).for_each(|i| scaled[i * k + i] += RIDGE);
        if cholesky::factor(&mut scaled, k).is_err() {
            return 0.0;
        }
        let mut b: Vec<f64> = columns.iter().zip(&scales).map(|(column, scale)| dot(column, &errors) / scale).collect();
        cholesky::solve_lower(&scaled, &mut b);
        let log_scales: f64 = scales.iter().map(|scale| crate::math::functions::ln(*scale)).sum();
        0.5 * dot(&b, &b) - 0.5 * cholesky::log_determinant(&scaled, k) - log_scales
    }
}
