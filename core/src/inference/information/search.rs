//! Bayesian optimisation over continuous conditions: a Gaussian process through the values found so far proposes where
//! the next one is worth most.
//!
//! Jones, Schonlau & Welch (1998, J. Global Optim. 13, 455): expected improvement, with the covariance Matern 5/2 and a
//! constant mean (Rasmussen & Williams 2006, eqs 2.25, 4.17). Limits that must be kept: the improvement times the
//! probability that they are (Gardner et al. 2014, ICML). Several points at once: each is taken to give what the process
//! expects of it before the next is sought (Ginsbourger, Le Riche & Carraro 2010, kriging believer).
//!
//! The process only says where to look: what is reported of a point is its own estimate.

use crate::math::cholesky;
use crate::math::functions::{exp, ln};
use crate::math::special::{normal_cdf, normal_density};
use crate::random::{PointKind, Points, StreamKey};

/// Lengths that are tried for each coordinate, in widths of its range.
const LENGTHS: [f64; 9] = [0.06, 0.1, 0.16, 0.25, 0.4, 0.63, 1.0, 1.8, 4.0];
/// Sweeps over the coordinates in which the lengths are chosen.
const SWEEPS: usize = 3;
/// Added to the correlations' diagonal, so that rounding leaves them positive definite.
const JITTER: f64 = 1e-8;
/// Points over the whole range, and round the best, at which the improvement is looked at.
const SPREAD: usize = 1024;
const NEAR: usize = 64;
/// Halvings of the step of the last, local search.
const HALVINGS: u32 = 12;

/// A Gaussian process with a constant mean, conditioned on values.
#[derive(Clone, Debug)]
pub struct Process {
    /// Points in the unit cube.
    points: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    mean: f64,
    variance: f64,
    factor: Vec<f64>,
    /// `C^-1 (y - mean)`, `C` the correlations.
    weights: Vec<f64>,
    log_likelihood: f64,
}

/// Matern 5/2 at a scaled distance.
fn correlation(a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).zip(lengths).map(|((a, b), l)| (a - b) * (a - b) / (l * l)).sum();
    let r = (5.0 * square).sqrt();
    (1.0 + r + r * r / 3.0) * exp(-r)
}

impl Process {
    /// Through `values` at `points` (each in the unit cube), with the lengths of the highest likelihood; mean and variance
    /// are profiled. `None` without two different finite values.
    pub fn fit(points: &[Vec<f64>], values: &[f64]) -> Option<Self> {
        let dimensions = points.first()?.len();
        let spread = values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - values.iter().copied().fold(f64::INFINITY, f64::min);
        if !(spread > 0.0 && spread.is_finite()) || points.len() != values.len() {
            return None;
        }
        let mut lengths = vec![0.4; dimensions];
        let mut best = Self::with_lengths(points, values, &lengths);
        for _ in 0..SWEEPS {
            let before = lengths.clone();
            for coordinate in 0..dimensions {
                for length in LENGTHS {
                    let mut trial = lengths.clone();
                    trial[coordinate] = length;
                    let process = Self::with_lengths(points, values, &trial);
                    let likelihood =
                        |fitted: &Option<Self>| fitted.as_ref().map_or(f64::NEG_INFINITY, |p| p.log_likelihood);
                    if likelihood(&process) > likelihood(&best) {
                        (best, lengths) = (process, trial);
                    }
                }
            }
            if lengths == before {
                break;
            }
        }
        best
    }

    fn with_lengths(points: &[Vec<f64>], values: &[f64], lengths: &[f64]) -> Option<Self> {
        let n = points.len();
        let mut factor = vec![0.0; n * n];
        for a in 0..n {
            for b in 0..=a {
                factor[a * n + b] = correlation(&points[a], &points[b], lengths) + if a == b { JITTER } else { 0.0 };
            }
        }
        cholesky::factor(&mut factor, n).ok()?;
        let (mut ones, mut whitened) = (vec![1.0; n], values.to_vec());
        cholesky::solve_lower(&factor, &mut ones);
        cholesky::solve_lower(&factor, &mut whitened);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mean = dot(&ones, &whitened) / dot(&ones, &ones);
        let mut weights: Vec<f64> = whitened.iter().zip(&ones).map(|(y, one)| y - mean * one).collect();
        let variance = dot(&weights, &weights) / n as f64;
        if !(variance > 0.0 && variance.is_finite()) {
            return None;
        }
        let log_likelihood = -0.5 * (n as f64 * ln(variance) + cholesky::log_determinant(&factor, n));
        cholesky::solve_lower_transposed(&factor, &mut weights);
        let (points, lengths) = (points.to_vec(), lengths.to_vec());
        Some(Self { points, lengths, mean, variance, factor, weights, log_likelihood })
    }

    /// Expectation and standard deviation at a point of the unit cube.
    pub fn at(&self, point: &[f64]) -> (f64, f64) {
        let mut column: Vec<f64> = self.points.iter().map(|sample| correlation(sample, point, &self.lengths)).collect();
        let mean = self.mean + column.iter().zip(&self.weights).map(|(c, w)| c * w).sum::<f64>();
        cholesky::solve_lower(&self.factor, &mut column);
        let left = 1.0 - column.iter().map(|c| c * c).sum::<f64>();
        (mean, (self.variance * left.max(0.0)).sqrt())
    }
}

/// `E max(0, y - best)` of a normal `y`.
pub fn expected_improvement(mean: f64, sd: f64, best: f64) -> f64 {
    let over = mean - best;
    if !(sd > 0.0) {
        return over.max(0.0);
    }
    let z = over / sd;
    (over * normal_cdf(z) + sd * normal_density(z)).max(0.0)
}

/// What is known of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// Position in the unit cube.
    pub point: Vec<f64>,
    /// Its value; `None` where it has none.
    pub value: Option<f64>,
    /// By how much its worst limit is exceeded, above 0 where it is not allowed.
    pub excess: f64,
}

/// The next `count` points of the unit cube at which a larger value within the limits may be expected, rounded to
/// `1 / steps`; fewer where nothing more is to be expected. `key` gives the points at which the improvement is looked at.
pub fn next(evaluated: &[Known], count: usize, steps: f64, key: &StreamKey) -> Vec<Vec<f64>> {
    let mut evaluated = evaluated.to_vec();
    let mut points = Vec::new();
    for _ in 0..count {
        let Some((point, value, excess)) = one(&evaluated, steps, key) else { break };
        points.push(point.clone());
        evaluated.push(Known { point, value: Some(value), excess });
    }
    points
}

fn one(evaluated: &[Known], steps: f64, key: &StreamKey) -> Option<(Vec<f64>, f64, f64)> {
    let dimensions = evaluated.first()?.point.len();
    let valued: Vec<(&Known, f64)> = evaluated.iter().filter_map(|sample| Some((sample, sample.value?))).collect();
    let points: Vec<Vec<f64>> = valued.iter().map(|(sample, _)| sample.point.clone()).collect();
    let values: Vec<f64> = valued.iter().map(|(_, value)| *value).collect();
    let process = Process::fit(&points, &values)?;
    let all: Vec<Vec<f64>> = evaluated.iter().map(|sample| sample.point.clone()).collect();
    let excesses: Vec<f64> = evaluated.iter().map(|sample| sample.excess).collect();
    let has_forbidden = excesses.iter().any(|excess| *excess > 0.0);
    let limit = if has_forbidden { Process::fit(&all, &excesses) } else { None };
    let mut best: Option<(&Known, f64)> = None;
    for &(sample, value) in valued.iter().filter(|(sample, _)| sample.excess <= 0.0) {
        if best.is_none_or(|(_, most)| value > most) {
            best = Some((sample, value));
        }
    }
    let (centre, most) = best?;
    let worth = |point: &[f64]| {
        let (mean, sd) = process.at(point);
        let allowed = limit.as_ref().map_or(1.0, |limit| {
            let (excess, sd) = limit.at(point);
            if sd > 0.0 { normal_cdf(-excess / sd) } else { f64::from(u8::from(excess <= 0.0)) }
        });
        expected_improvement(mean, sd, most) * allowed
    };
    let mut rows = vec![0.0; SPREAD * dimensions];
    Points::new(PointKind::Sobol, *key, SPREAD, dimensions).ok()?.fill_rows(0, &mut rows);
    let near = rows.chunks_exact(dimensions).take(NEAR).flat_map(|row| {
        // Shrinking boxes round the best point.
        [0.3, 0.1, 0.03, 0.01].map(|half| -> Vec<f64> {
            centre.point.iter().zip(row).map(|(c, u)| (c + half * (2.0 * u - 1.0)).clamp(0.0, 1.0)).collect()
        })
    });
    let mut at: Option<(Vec<f64>, f64)> = None;
    for point in rows.chunks_exact(dimensions).map(<[f64]>::to_vec).chain(near) {
        let improvement = worth(&point);
        if at.as_ref().is_none_or(|(_, most)| improvement > *most) {
            at = Some((point, improvement));
        }
    }
    let (mut point, mut improvement) = at?;
    let mut step = 0.05;
    for _ in 0..HALVINGS {
        for coordinate in 0..dimensions {
            for sign in [-1.0, 1.0] {
                let mut trial = point.clone();
                trial[coordinate] = (trial[coordinate] + sign * step).clamp(0.0, 1.0);
                let other = worth(&trial);
                if other > improvement {
                    (point, improvement) = (trial, other);
                }
            }
        }
        step *= 0.5;
    }
    point.iter_mut().for_each(|u| *u = (*u * steps).round() / steps);
    let is_new =
        !evaluated.iter().any(|other| other.point.iter().zip(&point).all(|(a, b)| (a - b).abs() < 0.5 / steps));
    if !(improvement > 0.0 && is_new) {
        return None;
    }
    let expected = process.at(&point).0;
    let excess = limit.as_ref().map_or(0.0, |limit| limit.at(&point).0);
    Some((point, expected, excess))
}
