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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::StreamKey;

    const SIGMA: f64 = 0.5;

    /// Old inputs of a straight line against a constant.
    const OLD: [f64; 4] = [0.0, 1.0, 2.0, 3.0];

    /// The rival `y = c`, fitted to noise-free readings of `y = 1 + 0.2 x` at the old inputs: c = 1.3, variance
    /// sigma^2 / 4; at x it predicts 1.3.
    fn constant(new: &[f64]) -> Separation {
        let truth: Vec<f64> = new.iter().map(|x| 1.0 + 0.2 * x).collect();
        let c = covariance(&[0.0], &[1.0; 4], &[SIGMA; 4], 1).expect("regular");
        assert!((c[0] - SIGMA * SIGMA / 4.0).abs() < 1e-15);
        let mean = vec![1.3; new.len()];
        let derivatives = vec![1.0; new.len()];
        let rival = Rival { mean: &mean, derivatives: &derivatives, covariance: &c, parameters: 1 };
        let n = new.len();
        let noise: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { SIGMA * SIGMA } else { 0.0 }).collect();
        from_truth(&truth, &rival, &noise).expect("regular")
    }

    /// Rise of the rival's least sum of squares from the old readings to all, by fitting anew.
    fn rise(new: &[f64]) -> f64 {
        let squares = |inputs: &[f64]| {
            let values: Vec<f64> = inputs.iter().map(|x| 1.0 + 0.2 * x).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / (SIGMA * SIGMA)
        };
        let all: Vec<f64> = OLD.iter().chain(new).copied().collect();
        squares(&all) - squares(&OLD)
    }

    #[test]
    fn the_distance_is_the_rise_of_the_refitted_rivals_misfit() {
        for new in [&[10.0][..], &[10.0, 12.0], &[0.0], &OLD] {
            let separation = constant(new);
            assert!((separation.distance_squared - rise(new)).abs() < 1e-12, "{new:?}");
        }
        // Repeating the middle tells less than going far.
        assert!(constant(&[1.0]).probability < constant(&[10.0]).probability);
    }

    #[test]
    fn the_probability_is_that_of_the_best_test_between_two_normal_distributions() {
        // Readings about mu_1 or mu_2 with covariance S = Sigma + F C F'; the likelihood ratio decides. 40 000 draws: four
        // standard errors are 0.008.
        let (c, d): (f64, f64) = (0.3, 0.9);
        let rival = Rival { mean: &[d, -d], derivatives: &[1.0, 2.0], covariance: &[c], parameters: 1 };
        let separation = from_truth(&[0.0, 0.0], &rival, &[0.25, 0.0, 0.0, 0.25]).expect("regular");
        let s = [0.25 + c, 2.0 * c, 0.25 + 4.0 * c];
        let determinant = s[0] * s[2] - s[1] * s[1];
        let w = [(s[2] * d + s[1] * d) / determinant, (-s[1] * d - s[0] * d) / determinant];
        let square = w[0] * d - w[1] * d;
        assert!((separation.distance_squared - square).abs() < 1e-12);
        let l = [s[0].sqrt(), s[1] / s[0].sqrt(), (determinant / s[0]).sqrt()];
        let mut stream = StreamKey::new(3, "separation", "test").stream(0);
        let mut right = 0;
        for k in 0..40_000 {
            let (a, b) = (stream.normal(), stream.normal());
            let noise = [l[0] * a, l[1] * a + l[2] * b];
            let is_second = k % 2 == 1;
            let shift = if is_second { d } else { 0.0 };
            let z = [noise[0] + shift, noise[1] - shift];
            let says_second = w[0] * z[0] + w[1] * z[1] > 0.5 * square;
            right += u32::from(says_second == is_second);
        }
        assert!((f64::from(right) / 40_000.0 - separation.probability).abs() < 0.008);
    }

    #[test]
    fn rivals_that_agree_are_not_told_apart() {
        let rival = Rival { mean: &[1.0], derivatives: &[2.0], covariance: &[0.1], parameters: 1 };
        let fixed = Rival { mean: &[2.0], derivatives: &[], covariance: &[], parameters: 0 };
        assert_eq!(between(&rival, &rival, &[1.0]).expect("regular").probability, 0.5);
        // Whichever is right: against the rival that can adapt.
        let least_of = between(&rival, &fixed, &[1.0]).expect("regular");
        assert!((least_of.distance_squared - 1.0 / 1.4).abs() < 1e-15);
        let (separation, pair) = least(&[rival, fixed, rival], &[1.0]).expect("regular").expect("pairs");
        assert_eq!((separation.probability, pair), (0.5, [0, 2]));
        assert_eq!(least(&[rival], &[1.0]), Ok(None));
    }

    #[test]
    fn shapes_and_covariances_are_checked() {
        let rival = Rival { mean: &[1.0], derivatives: &[2.0], covariance: &[0.1], parameters: 1 };
        assert!(matches!(from_truth(&[1.0, 2.0], &rival, &[1.0]), Err(SeparationError::Shape { .. })));
        assert_eq!(from_truth(&[1.0], &rival, &[-1.0]), Err(SeparationError::Covariance));
        assert_eq!(from_truth(&[f64::NAN], &rival, &[1.0]), Err(SeparationError::Covariance));
        assert!(covariance(&[0.0], &[0.0], &[1.0], 1).is_err());
    }
}
