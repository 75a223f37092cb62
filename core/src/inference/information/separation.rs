//! How well an experiment would tell two rival models apart, with all models linearised.
//!
//! One rival's prediction `mu_1` is taken as the truth; the other is fitted anew to the old and the new data together.
//! With `C` the covariance of its parameters after the old data, its sum of squares then rises on average, beside the
//! noise, by (Box & Hill 1967, Technometrics 9, 57, with one rival as the truth; the matrix by Woodbury's identity)
//!
//! `delta^2 = (mu_1 - mu_2)' (Sigma + F C F')^-1 (mu_1 - mu_2)`.
//!
//! That is what the new data show: a test between two normal distributions that far apart, both as probable before, is
//! right with probability `Phi(delta / 2)`. Phases that are repeated are conditions like others.

use thiserror::Error;

use crate::math::cholesky;
use crate::math::special::normal_cdf;

/// A rival's prediction for one experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rival<'a> {
    /// Predicted readings at its most probable parameters after the old data.
    pub mean: &'a [f64],
    /// Derivatives `F` of the predictions, `readings x parameters`, row by row.
    pub derivatives: &'a [f64],
    /// Covariance `C` of its parameters after the old data, `parameters x parameters`.
    pub covariance: &'a [f64],
    /// Number of its parameters.
    pub parameters: usize,
}

/// How far two rivals are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// `delta^2`.
    pub distance_squared: f64,
    /// Probability `Phi(delta / 2)` that the new data tell which is right; 0.5 is a coin.
    pub probability: f64,
}

impl Separation {
    /// Of `delta^2`.
    fn of(distance_squared: f64) -> Self {
        Self { distance_squared, probability: normal_cdf(0.5 * distance_squared.max(0.0).sqrt()) }
    }
}

/// Why there is no separation.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SeparationError {
    /// Lists whose lengths do not fit together.
    #[error("{what} has {found} entries, expected {expected}")]
    Shape {
        /// The list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that fits.
        expected: usize,
    },
    /// A covariance of readings that is none, or numbers that are not finite.
    #[error("the covariance of the readings is not positive definite")]
    Covariance,
}

fn check(what: &'static str, list: &[f64], expected: usize) -> Result<(), SeparationError> {
    let length = list.len();
    if length == expected { Ok(()) } else { Err(SeparationError::Shape { what, found: length, expected }) }
}

/// How far `rival` is from readings that have the mean `truth`, after it was fitted to them too; `noise` is their
/// covariance `Sigma`, `readings x readings`. Cost: `readings^3 / 3 + readings parameters (readings + parameters)`.
///
/// # Errors
/// [`SeparationError`]: shapes that do not fit, a covariance that is not positive definite.
pub fn from_truth(truth: &[f64], rival: &Rival<'_>, noise: &[f64]) -> Result<Separation, SeparationError> {
    let (n, p) = (truth.len(), rival.parameters);
    check("the rival's mean", rival.mean, n)?;
    check("the rival's derivatives", rival.derivatives, n * p)?;
    check("the rival's covariance", rival.covariance, p * p)?;
    check("the covariance of the noise", noise, n * n)?;
    let mut matrix = noise.to_vec();
    let mut row = vec![0.0; p];
    for a in 0..n {
        let slopes = &rival.derivatives[a * p..(a + 1) * p];
        for (k, slot) in row.iter_mut().enumerate() {
            *slot = slopes.iter().zip(0..p).map(|(f, j)| f * rival.covariance[j * p + k]).sum();
        }
        for b in 0..=a {
            let other = &rival.derivatives[b * p..(b + 1) * p];
            matrix[a * n + b] += row.iter().zip(other).map(|(x, f)| x * f).sum::<f64>();
        }
    }
    cholesky::factor(&mut matrix, n).map_err(|_| SeparationError::Covariance)?;
    let mut apart: Vec<f64> = truth.iter().zip(rival.mean).map(|(a, b)| a - b).collect();
    cholesky::solve_lower(&matrix, &mut apart);
    let squared = apart.iter().map(|value| value * value).sum::<f64>();
    if squared.is_finite() { Ok(Separation::of(squared)) } else { Err(SeparationError::Covariance) }
}

/// How far two rivals are apart whichever of them is right: the lesser of both ways.
///
/// # Errors
/// As [`from_truth`].
pub fn between(first: &Rival<'_>, second: &Rival<'_>, noise: &[f64]) -> Result<Separation, SeparationError> {
    let ways = [from_truth(first.mean, second, noise)?, from_truth(second.mean, first, noise)?];
    Ok(if ways[1].distance_squared < ways[0].distance_squared { ways[1] } else { ways[0] })
}

/// The least separation of any two of several rivals, and which two they are.
///
/// # Errors
/// As [`from_truth`].
pub fn least(rivals: &[Rival<'_>], noise: &[f64]) -> Result<Option<(Separation, [usize; 2])>, SeparationError> {
    let mut least: Option<(Separation, [usize; 2])> = None;
    for second in 1..rivals.len() {
        for first in 0..second {
            let separation = between(&rivals[first], &rivals[second], noise)?;
            if least.is_none_or(|(other, _)| separation.distance_squared < other.distance_squared) {
                least = Some((separation, [first, second]));
            }
        }
    }
    Ok(least)
}

/// Covariance of parameters after data: the inverse of `prior_precision + F' Sigma^-1 F` for independent readings with
/// standard deviations `sigma`; `derivatives` is `readings x parameters`.
///
/// # Errors
/// [`SeparationError`]: shapes that do not fit, parameters that neither the data nor the prior bounds.
pub fn covariance(
    prior_precision: &[f64],
    derivatives: &[f64],
    sigma: &[f64],
    parameters: usize,
) -> Result<Vec<f64>, SeparationError> {
    let p = parameters;
    check("the prior's precision", prior_precision, p * p)?;
    check("the derivatives", derivatives, sigma.len() * p)?;
    let mut matrix = prior_precision.to_vec();
    for (row, sigma) in derivatives.chunks_exact(p.max(1)).zip(sigma) {
        for a in 0..p {
            for b in 0..=a {
                matrix[a * p + b] += row[a] * row[b] / (sigma * sigma);
            }
        }
    }
    cholesky::factor(&mut matrix, p).map_err(|_| SeparationError::Covariance)?;
    Ok(cholesky::inverse(&matrix, p))
}
