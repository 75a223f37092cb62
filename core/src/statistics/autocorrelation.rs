//! Autocorrelation of a series and the number of independent values that it is worth.

use super::moments::Moments;
use crate::math::sum::compensated;

/// Autocovariance at a lag with divisor n, about the sample mean.
pub fn autocovariance(values: &[f64], lag: usize) -> f64 {
    covariance_about(values, Moments::of(values).mean(), lag)
}

fn covariance_about(values: &[f64], mean: f64, lag: usize) -> f64 {
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

/// Independent values worth as much for a mean: n over `1 + 2 sum of autocorrelations`, summed in pairs of lags while these stay
/// positive and never let rise (Geyer 1992, initial monotone sequence), within 1..=n. Cost: n times the lags summed.
pub fn effective_size(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = Moments::of(values).mean();
    let variance = covariance_about(values, mean, 0);
    if values.len() < 4 || variance.is_nan() || variance <= 0.0 {
        return n;
    }
    let (mut sum, mut smallest) = (0.0, f64::INFINITY);
    for lag in (0..values.len() - 1).step_by(2) {
        let pair = (covariance_about(values, mean, lag) + covariance_about(values, mean, lag + 1)) / variance;
        if pair <= 0.0 {
            break;
        }
        smallest = pair.min(smallest);
        sum += smallest;
    }
    (n / (2.0 * sum - 1.0).max(1.0)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn autocovariance_by_hand() {
        // Mean 2.5, deviations -1.5 -0.5 0.5 1.5.
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(autocovariance(&values, 0), 1.25);
        assert_eq!(autocovariance(&values, 1), (0.75 - 0.25 + 0.75) / 4.0);
        assert_eq!(autocovariance(&values, 4), 0.0);
        assert_eq!((lag_one(&values), lag_one(&[2.0; 9])), (0.25, 0.0));
        assert_eq!((effective_size_lag_one(&values), effective_size(&[1.0; 10])), (2.4, 10.0));
    }
}
