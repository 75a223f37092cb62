//! A parameter that is known better than by its prior: the prior times the likelihood of one measurement with a normal error.
//!
//! The product has no closed form for every prior; it is tabulated over the prior's probabilities, in cells of equal
//! probability each weighted at its middle, so that any kind of prior will do and an error without end gives the prior back.

use serde::{Deserialize, Serialize};

use crate::math::functions::exp;
use crate::random::Distribution;

/// Cells of the table.
const CELLS: usize = 2048;
/// An error of so many standard deviations of the prior tells nothing.
const USELESS: f64 = 1e8;
/// Below this ratio of standard deviations the table has too few cells: knowledge counts as perfect.
pub const SHARPEST: f64 = 0.01;

/// Knowledge of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Index of the parameter.
    pub parameter: usize,
    /// What was measured, SI.
    pub reading: f64,
    /// Standard deviation of the measurement's error, SI; 0 for perfect knowledge.
    pub error: f64,
}

/// Quantiles of a sharpened prior.
#[derive(Clone, Debug)]
pub struct Sharpened {
    prior: Distribution,
    /// Perfectly known value.
    fixed: Option<f64>,
    /// Probability at the upper edge of each cell.
    cumulative: Vec<f64>,
}

/// Values of a prior at the middles of the cells.
pub fn middles(prior: &Distribution) -> Vec<f64> {
    (0..CELLS).map(|cell| prior.quantile((cell as f64 + 0.5) / CELLS as f64)).collect()
}

/// Weights of the cells for a reading with an error, the largest 1.
fn weights(middles: &[f64], reading: f64, error: f64) -> Vec<f64> {
    let exponents: Vec<f64> = middles
        .iter()
        .map(|x| {
            let z = (x - reading) / error;
            -0.5 * z * z
        })
        .collect();
    let largest = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    exponents.iter().map(|exponent| exp(exponent - largest)).collect()
}

/// Standard deviation of weighted values.
fn spread(middles: &[f64], weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let mean = middles.iter().zip(weights).map(|(x, w)| w * x).sum::<f64>() / total;
    (middles.iter().zip(weights).map(|(x, w)| w * (x - mean) * (x - mean)).sum::<f64>() / total).sqrt()
}

/// Error of a measurement at the prior's mean that leaves a share `ratio` of the prior's standard deviation; so large
/// that nothing is learned for 1 or more, 0 below [`SHARPEST`].
pub fn error_for(prior: &Distribution, ratio: f64) -> f64 {
    if ratio < SHARPEST {
        return 0.0;
    }
    let middles = middles(prior);
    let (sd, mean) = (spread(&middles, &[1.0; CELLS]), prior.mean());
    if ratio >= 1.0 {
        return USELESS * sd;
    }
    // The spread rises with the error; halving on its logarithm.
    let (mut low, mut high) = (0.1 * ratio * sd, 1e4 * sd);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if spread(&middles, &weights(&middles, mean, middle)) < ratio * sd { low = middle } else { high = middle }
    }
    (low * high).sqrt()
}

impl Sharpened {
    /// The prior of a parameter, sharpened.
    pub fn new(prior: &Distribution, known: &Known) -> Self {
        if known.error <= 0.0 {
            return Self { prior: *prior, fixed: Some(known.reading), cumulative: Vec::new() };
        }
        let weights = weights(&middles(prior), known.reading, known.error);
        let total: f64 = weights.iter().sum();
        let mut sum = 0.0;
        let cumulative = weights
            .iter()
            .map(|weight| {
                sum += weight;
                sum / total
            })
            .collect();
        Self { prior: *prior, fixed: None, cumulative }
    }

    /// The value below which a share `v` (in 0..1) lies.
    pub fn quantile(&self, v: f64) -> f64 {
        if let Some(fixed) = self.fixed {
            return fixed;
        }
        let cell = self.cumulative.partition_point(|&upper| upper < v).min(CELLS - 1);
        let lower = if cell == 0 { 0.0 } else { self.cumulative[cell - 1] };
        let width = self.cumulative[cell] - lower;
        let share = if width > 0.0 { ((v - lower) / width).clamp(0.0, 1.0) } else { 0.5 };
        // Strictly inside: the ends of a prior without bounds are infinite.
        let u = ((cell as f64 + share) / CELLS as f64).clamp(f64::EPSILON, 1.0 - f64::EPSILON);
        self.prior.quantile(u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Moments;

    fn sharpened(prior: Distribution, reading: f64, error: f64) -> Moments {
        let sharpened = Sharpened::new(&prior, &Known { parameter: 0, reading, error });
        let n = 20_000;
        Moments::of(&(0..n).map(|i| sharpened.quantile((f64::from(i) + 0.5) / f64::from(n))).collect::<Vec<_>>())
    }

    #[test]
    fn a_normal_prior_and_a_normal_error_are_conjugate() {
        // Precisions add: 1/4 + 1 = 5/4; mean (3/4 + 5) / (5/4).
        let prior = Distribution::Normal { mean: 3.0, sd: 2.0, lower: None, upper: None };
        let moments = sharpened(prior, 5.0, 1.0);
        assert!((moments.mean() - 4.6).abs() < 1e-3, "{}", moments.mean());
        // The cells cut the tails: a thousandth.
        assert!((moments.sd() / 0.8_f64.sqrt() - 1.0).abs() < 2e-3, "{}", moments.sd());
    }

    #[test]
    fn a_small_error_within_a_uniform_prior_is_left_as_it_is() {
        let prior = Distribution::Uniform { lower: 0.78, upper: 0.92 };
        let moments = sharpened(prior, 0.85, 0.005);
        assert!((moments.mean() - 0.85).abs() < 1e-6 && (moments.sd() / 0.005 - 1.0).abs() < 1e-3, "{}", moments.sd());
    }

    #[test]
    fn the_error_leaves_the_ratio_asked_for() {
        for prior in [
            Distribution::Uniform { lower: 0.0, upper: 3.0 },
            Distribution::LogNormal { median: 2.0, factor: 1.4 },
            Distribution::Triangular { lower: 0.0, mode: 0.2, upper: 1.0 },
        ] {
            for ratio in [0.9, 0.5, 0.1, 0.02] {
                let error = error_for(&prior, ratio);
                let moments = sharpened(prior, prior.mean(), error);
                // The tails of a lognormal prior are cut by the cells.
                assert!((moments.sd() / prior.sd() / ratio - 1.0).abs() < 0.01, "{prior:?} {ratio}: {}", moments.sd());
            }
        }
    }

    #[test]
    fn no_error_is_perfect_and_one_without_end_is_the_prior() {
        let prior = Distribution::Uniform { lower: 0.0, upper: 2.0 };
        assert_eq!(error_for(&prior, 0.001), 0.0);
        let sharpened_by = |error| Sharpened::new(&prior, &Known { parameter: 0, reading: 1.5, error });
        assert_eq!(sharpened_by(0.0).quantile(0.1), 1.5);
        assert!((sharpened_by(error_for(&prior, 1.0)).quantile(0.1) - 0.2).abs() < 1e-12);
    }
}
