//! Autocorrelation of a series and the number of independent values that it is worth.

use super::moments::Moments;
use crate::math::sum::compensated;

/// Autocovariance at a lag with divisor n, about the sample mean.
pub fn autocovariance(values: &[f64], lag: usize) -> f64 {
    let mean = Moments::of(values).mean();
    let later = values.get(lag..).unwrap_or_default();
    compensated(values.iter().zip(later).map(|(a, b)| (a - mean) * (b - mean))) / values.len() as f64
}

/// Autocorrelation at lag 1; 0 for a series that does not vary.
pub fn lag_one(values: &[f64]) -> f64 {
    let variance = autocovariance(values, 0);
    if variance > 0.0 { autocovariance(values, 1) / variance } else { 0.0 }
}

/// Independent values worth as much for a mean as a first-order autoregressive series with this lag-1 autocorrelation:
/// `n (1 - r) / (1 + r)`, within 1..=n (Bayley & Hammersley 1946).
pub fn effective_size_lag_one(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let r = lag_one(values).max(0.0);
    (n * (1.0 - r) / (1.0 + r)).max(1.0).min(n)
}
