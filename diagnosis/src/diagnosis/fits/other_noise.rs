//! A fit's log evidence with another noise than that it was made with.
//!
//! Where the variance of all readings is `k` times as large, the data weigh `1/k`. About the fit the posterior density is
//! normal (Laplace): in coordinates whose prior is the standard normal distribution, and along the eigenvectors of the
//! covariance, the data's curvature is `l`, the covariance `1 / (1 + l)` and the most probable value `m`. With the curvature
//! `l/k` the most probable value moves towards the prior's, and the volume grows, but not beyond the prior's.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::inference::estimate::point_estimate::PointEstimate;
use crate::math::functions::{ln, sqrt};
use crate::random::Distribution;

/// Least share of the prior's variance that is left: less than rounding leaves of a covariance.
const LEAST_LEFT: f64 = 1e-12;

/// A direction in the space of the parameters, along which neither data nor priors tie it to the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// Curvature of half the data's sum of squares, in that of the prior.
    pub data: f64,
    /// Most probable value, in the prior's standard deviations from its centre.
    pub away: f64,
}

/// The distance of a value from a prior's centre, in standard deviations, and these in SI. Priors without a slope pull
/// nowhere.
pub fn scale(prior: &Distribution, value: f64) -> (f64, f64) {
    match *prior {
        Distribution::Normal { mean, sd, .. } => ((value - mean) / sd, sd),
        Distribution::HalfNormal { scale } => (value / scale, scale),
        Distribution::LogNormal { median, factor } => (ln(value / median) / ln(factor), ln(factor) * value),
        Distribution::LogUniform { lower, upper } => (0.0, ln(upper / lower) / sqrt(12.0) * value),
        _ => (0.0, prior.sd()),
    }
}

/// The directions of a fit's free parameters.
pub fn directions(found: &PointEstimate, priors: &[Distribution]) -> Vec<Direction> {
    let width = found.parameters.len();
    let scaled: Vec<(usize, f64, f64)> = (0..width)
        .filter(|&place| found.held[place].is_none())
        .map(|place| {
            let (away, sd) = scale(&priors[place], found.parameters[place]);
            (place, away, sd)
        })
        .filter(|(_, away, sd)| away.is_finite() && *sd > 0.0 && sd.is_finite())
        .collect();
    let n = scaled.len();
    let covariance = DMatrix::from_fn(n, n, |a, b| {
        let ((i, _, own), (j, _, other)) = (scaled[a], scaled[b]);
        found.covariance[i * width + j] / (own * other)
    });
    if n == 0 || covariance.iter().any(|value| !value.is_finite()) {
        return Vec::new();
    }
    let eigen = covariance.symmetric_eigen();
    (0..n)
        .map(|e| Direction {
            data: 1.0 / eigen.eigenvalues[e].clamp(LEAST_LEFT, 1.0) - 1.0,
            away: (0..n).map(|a| eigen.eigenvectors[(a, e)] * scaled[a].1).sum(),
        })
        .collect()
}

/// What the priors and the volume add to the log evidence where the variance of all readings is `times` as large: beyond
/// what they add at the fit, and beside the likelihood of the fit's own errors with that variance.
///
/// Along a direction the evidence without constants is `-l/k d^2 / (2 (1 + l/k)) - ln(1 + l/k) / 2`, with `d = m (1 + l) / l`
/// where the data alone would have it. The fit's errors and its prior density give `-l/k (m - d)^2 / 2 - m^2 / 2`.
pub fn gain(directions: &[Direction], times: f64) -> f64 {
    let one = |own: &Direction| {
        let moves = (times - 1.0) * (times - 1.0) / (times * (times + own.data));
        0.5 * (own.away * own.away * moves + ln((1.0 + own.data) / (1.0 + own.data / times)))
    };
    directions.iter().map(one).sum()
}

/// A fit's log evidence with the variance that is most likely beside it in place of the one that it was made with: all variances
/// `chi^2 / n` times as large, with `n` independent readings. The evidence itself where `n` is 0.
pub fn with_own_noise(log_evidence: f64, chi_square: f64, readings: f64, directions: &[Direction]) -> f64 {
    let times = chi_square / readings;
    if !(times > 0.0 && times.is_finite()) {
        return log_evidence;
    }
    log_evidence + 0.5 * (chi_square - readings * (1.0 + ln(times))) + gain(directions, times)
}

/// Parameters that the data determine where the variance of all readings is `times` as large (MacKay 1992, eq. 4.9).
pub fn determined(directions: &[Direction], times: f64) -> f64 {
    directions.iter().map(|own| own.data / (own.data + times)).sum()
}
