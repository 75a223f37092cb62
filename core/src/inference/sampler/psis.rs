//! Pareto-smoothed importance sampling and leave-one-out cross-validation.
//!
//! The largest importance weights are replaced by the expected order statistics of a generalised Pareto distribution
//! fitted to them (Vehtari, Simpson, Gelman, Yao & Gabry 2024; fit of Zhang & Stephens 2009 with a weak prior of weight
//! ten at 1/2 on the shape). The shape `k` tells whether the weights can be trusted.

use serde::{Deserialize, Serialize};

use crate::math::functions::{exp, exp_m1, ln, ln_1p};
use crate::math::sum::log_sum_exp;

/// Smoothed weights.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothedWeights {
    /// Logarithms of the weights, which sum to one.
    pub log_weights: Vec<f64>,
    /// Shape of the tail; infinite where too few weights lie in it to tell.
    pub pareto_k: f64,
}

/// Smooths the largest of the weights whose logarithms (up to a constant; minus infinity for no weight) are given.
///
/// `relative_efficiency`: effective by actual number of draws, 1 for independent draws.
pub fn smooth(log_ratios: &[f64], relative_efficiency: f64) -> SmoothedWeights {
    let count = log_ratios.len();
    let largest = log_ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return SmoothedWeights { log_weights: log_ratios.to_vec(), pareto_k: f64::INFINITY };
    }
    let mut log_weights: Vec<f64> = log_ratios.iter().map(|l| l - largest).collect();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| log_weights[a].total_cmp(&log_weights[b]));
    let size = count as f64;
    let tail = (size / 5.0).min(3.0 * (size / relative_efficiency).sqrt()).ceil() as usize;
    let cut = if tail < count { log_weights[order[count - tail - 1]] } else { f64::NEG_INFINITY };
    let cut = cut.max(ln(f64::MIN_POSITIVE));
    // Weights equal to the cut are no part of the tail.
    let tail_order: Vec<usize> = order.iter().copied().filter(|&i| log_weights[i] > cut).collect();
    let mut pareto_k = f64::INFINITY;
    if tail_order.len() > 4 {
        let base = exp(cut);
        let excesses: Vec<f64> = tail_order.iter().map(|&i| exp(log_weights[i]) - base).collect();
        let fit = ParetoFit::new(&excesses);
        pareto_k = fit.shape;
        if pareto_k.is_finite() {
            let tail_size = tail_order.len() as f64;
            for (rank, &i) in tail_order.iter().enumerate() {
                let expected = fit.quantile((rank as f64 + 0.5) / tail_size);
                log_weights[i] = ln(expected + base).min(0.0);
            }
        }
    }
    let total = log_sum_exp(&log_weights);
    for weight in &mut log_weights {
        *weight -= total;
    }
    SmoothedWeights { log_weights, pareto_k }
}

/// A generalised Pareto distribution of excesses.
struct ParetoFit {
    shape: f64,
    scale: f64,
}

impl ParetoFit {
    /// Fit to ascending excesses above 0.
    fn new(excesses: &[f64]) -> Self {
        let count = excesses.len();
        let size = count as f64;
        let candidates = 30 + (size.sqrt() as usize);
        let quartile = excesses[(size / 4.0 + 0.5) as usize - 1];
        let last = excesses[count - 1];
        let shape_at = |b: f64| excesses.iter().map(|x| ln_1p(-b * x)).sum::<f64>() / size;
        let profile: Vec<(f64, f64)> = (1..=candidates)
            .map(|i| {
                let b = 1.0 / last + (1.0 - (candidates as f64 / (i as f64 - 0.5)).sqrt()) / (3.0 * quartile);
                let k = shape_at(b);
                (b, size * (ln(-b / k) - k - 1.0))
            })
            .collect();
        let log_likelihoods: Vec<f64> = profile.iter().map(|p| p.1).collect();
        let total = log_sum_exp(&log_likelihoods);
        let (mut sum, mut weighted) = (0.0, 0.0);
        for (b, log_likelihood) in &profile {
            let weight = exp(log_likelihood - total);
            // Negligible candidates are left out, as in the reference implementation.
            if weight >= 10.0 * f64::EPSILON {
                sum += weight;
                weighted += weight * b;
            }
        }
        let b = weighted / sum;
        let raw = shape_at(b);
        Self { shape: (size * raw + 5.0) / (size + 10.0), scale: -raw / b }
    }

    /// The excess below which this share lies.
    fn quantile(&self, share: f64) -> f64 {
        let log_rest = ln_1p(-share);
        if self.shape.abs() < f64::EPSILON {
            -self.scale * log_rest
        } else {
            self.scale * exp_m1(-self.shape * log_rest) / self.shape
        }
    }
}

/// Expected log density of data left out one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeaveOneOut {
    /// Sum over the data.
    pub expected_log_density: f64,
    /// Its standard error, from the scatter over the data.
    pub standard_error: f64,
    /// Effective number of parameters.
    pub effective_parameters: f64,
    /// Log density of each datum, left out.
    pub pointwise: Vec<f64>,
    /// Shape of each datum's weights; above [`greatest_good_shape`] its value is not to be trusted.
    pub pareto_k: Vec<f64>,
}

/// The shape up to which smoothed weights of so many draws can be trusted: `min(1 - 1 / log10(draws), 0.7)`.
pub fn greatest_good_shape(draws: usize) -> f64 {
    (1.0 - core::f64::consts::LN_10 / ln(draws as f64)).min(0.7)
}

/// Leave-one-out from the log likelihood of each datum at each posterior draw (`draws x data`, draw by draw).
/// `None` without data or draws, or with a number that is not finite.
pub fn leave_one_out(log_likelihoods: &[f64], data: usize, relative_efficiency: f64) -> Option<LeaveOneOut> {
    if data == 0 || log_likelihoods.is_empty() || log_likelihoods.iter().any(|l| !l.is_finite()) {
        return None;
    }
    let draws = log_likelihoods.len() / data;
    let mut pointwise = Vec::with_capacity(data);
    let mut pareto_k = Vec::with_capacity(data);
    let mut full = 0.0;
    for datum in 0..data {
        let datum_log_likelihoods: Vec<f64> = (0..draws).map(|draw| log_likelihoods[draw * data + datum]).collect();
        let ratios: Vec<f64> = datum_log_likelihoods.iter().map(|l| -l).collect();
        let smoothed = smooth(&ratios, relative_efficiency);
        let terms: Vec<f64> = smoothed.log_weights.iter().zip(&datum_log_likelihoods).map(|(w, l)| w + l).collect();
        pointwise.push(log_sum_exp(&terms));
        pareto_k.push(smoothed.pareto_k);
        full += log_sum_exp(&datum_log_likelihoods) - ln(draws as f64);
    }
    let expected_log_density: f64 = pointwise.iter().sum();
    let mean = expected_log_density / data as f64;
    let squares: f64 = pointwise.iter().map(|p| (p - mean) * (p - mean)).sum();
    Some(LeaveOneOut {
        expected_log_density,
        standard_error: squares.sqrt(),
        effective_parameters: full - expected_log_density,
        pointwise,
        pareto_k,
    })
}
