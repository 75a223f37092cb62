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
