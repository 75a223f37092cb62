//! Kolmogorov and Smirnov's test of one sample against a distribution.

use crate::math::functions::{exp, sqrt};

/// Largest distance between the empirical distribution of a sorted sample and a distribution function; 0 for no values.
pub fn statistic_sorted(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let n = sorted.len() as f64;
    sorted.iter().enumerate().fold(0.0, |largest: f64, (k, &x)| {
        let p = cdf(x);
        largest.max((k as f64 + 1.0) / n - p).max(p - k as f64 / n)
    })
}

/// Probability of a statistic at least this large when the sample of the given size comes from the (continuous, fully
/// known) distribution: Kolmogorov's limit with Stephens's (1970) correction for the size, good to 0.01 from 5 values on.
pub fn p_value(statistic: f64, size: usize) -> f64 {
    let root = sqrt(size as f64);
    limit((root + 0.12 + 0.11 / root) * statistic)
}

/// Survival function of Kolmogorov's limiting distribution, by whichever of its two series converges faster.
pub fn limit(x: f64) -> f64 {
    if x.is_nan() {
        return f64::NAN;
    }
    if x < 0.04 {
        return 1.0;
    }
    if x < 1.18 {
        let scale = -std::f64::consts::PI * std::f64::consts::PI / (8.0 * x * x);
        let sum: f64 = [1.0, 9.0, 25.0, 49.0].iter().map(|square| exp(scale * square)).sum();
        return 1.0 - sqrt(2.0 * std::f64::consts::PI) / x * sum;
    }
    let term = |k: f64| exp(-2.0 * k * k * x * x);
    2.0 * (term(1.0) - term(2.0) + term(3.0) - term(4.0))
}
