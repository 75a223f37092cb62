//! Straight lines through points by least squares, with standard errors that know about autocorrelated residuals.

use super::autocorrelation::effective_size_lag_one;
use super::moments::Moments;
use crate::math::functions::sqrt;
use crate::math::sum::compensated;

/// A least-squares line `y = intercept + slope x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub intercept: f64,
    /// Change of y for one x.
    pub slope: f64,
    /// Residual standard deviation (divisor n - 2).
    pub residual_sd: f64,
    /// Standard error of the slope for independent residuals.
    pub slope_standard_error: f64,
    /// Number of points.
    pub size: usize,
}

impl Line {
    /// Fits points of rising or any order; `None` below three points or without spread in x.
    pub fn fit(x: &[f64], y: &[f64]) -> Option<Self> {
        let size = x.len();
        if size < 3 || y.len() != size {
            return None;
        }
        let (mean_x, mean_y) = (Moments::of(x).mean(), Moments::of(y).mean());
        let spread = compensated(x.iter().map(|x| (x - mean_x) * (x - mean_x)));
        if spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let slope = compensated(x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y))) / spread;
        let square = |(x, y): (&f64, &f64)| {
            let residual = (y - mean_y) - slope * (x - mean_x);
            residual * residual
        };
        let residual_sd = sqrt(compensated(x.iter().zip(y).map(square)) / (size as f64 - 2.0));
        let slope_standard_error = residual_sd / sqrt(spread);
        Some(Self { intercept: mean_y - slope * mean_x, slope, residual_sd, slope_standard_error, size })
    }

    /// Measured less fitted values.
    pub fn residuals(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        x.iter().zip(y).map(|(x, y)| y - (self.intercept + self.slope * x)).collect()
    }

    /// Standard error of the slope when the residuals, in the order of the points, are worth fewer independent values: scaled by
    /// `sqrt((n - 2) / (m - 2))` with m their effective size (at least 3) from the lag-1 autocorrelation (Santer et al. 2000).
    pub fn slope_standard_error_autocorrelated(&self, residuals: &[f64]) -> f64 {
        let effective = effective_size_lag_one(residuals).max(3.0);
        self.slope_standard_error * sqrt((self.size as f64 - 2.0) / (effective - 2.0)).max(1.0)
    }
}
