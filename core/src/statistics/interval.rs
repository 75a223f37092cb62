//! Confidence intervals of proportions and of normal estimates.

use crate::math::functions::sqrt;
use crate::math::special::{beta_quantile, normal_quantile};

/// A range of values, ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Estimate plus and minus the normal quantile for the confidence (in 0..1, two-sided) times the standard error.
    pub fn normal(estimate: f64, standard_error: f64, confidence: f64) -> Self {
        let reach = two_sided(confidence) * standard_error;
        Self { lower: estimate - reach, upper: estimate + reach }
    }

    /// Wilson's (1927) score interval for the probability behind `successes` in `trials`; 0..1 without trials.
    pub fn wilson(successes: u64, trials: u64, confidence: f64) -> Self {
        if trials == 0 {
            return Self { lower: 0.0, upper: 1.0 };
        }
        let (n, share) = (trials as f64, successes as f64 / trials as f64);
        let z = two_sided(confidence);
        let square = z * z / n;
        let middle = share + 0.5 * square;
        let reach = z * sqrt(share * (1.0 - share) / n + 0.25 * square / n);
        Self {
            lower: if successes == 0 { 0.0 } else { (middle - reach) / (1.0 + square) },
            upper: if successes == trials { 1.0 } else { (middle + reach) / (1.0 + square) },
        }
    }

    /// Wilson's interval around a share of weighted or clustered trials that are worth `effective` independent ones
    /// (above 0); 0..1 without trials.
    pub fn wilson_effective(share: f64, effective: f64, confidence: f64) -> Self {
        if !(effective > 0.0) {
            return Self { lower: 0.0, upper: 1.0 };
        }
        let z = two_sided(confidence);
        let square = z * z / effective;
        let middle = share + 0.5 * square;
        let reach = z * sqrt(share * (1.0 - share) / effective + 0.25 * square / effective);
        Self {
            lower: if share <= 0.0 { 0.0 } else { (middle - reach) / (1.0 + square) },
            upper: if share >= 1.0 { 1.0 } else { (middle + reach) / (1.0 + square) },
        }
    }

    /// Clopper and Pearson's (1934) interval, whose coverage is never below the confidence; 0..1 without trials.
    pub fn clopper_pearson(successes: u64, trials: u64, confidence: f64) -> Self {
        let tail = 0.5 * (1.0 - confidence);
        let (k, n) = (successes as f64, trials as f64);
        Self {
            lower: if successes == 0 { 0.0 } else { beta_quantile(tail, k, n - k + 1.0) },
            upper: if successes >= trials { 1.0 } else { beta_quantile(1.0 - tail, k + 1.0, n - k) },
        }
    }
}

/// Standard normal quantile of a two-sided confidence.
fn two_sided(confidence: f64) -> f64 {
    -normal_quantile(0.5 * (1.0 - confidence))
}
