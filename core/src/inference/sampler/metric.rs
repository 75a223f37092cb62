//! The metric of Hamiltonian trajectories: an estimate of the posterior's covariance over the coordinates.
//!
//! Momenta are normal with the inverse of the covariance as theirs, velocities are covariance times momentum.

use serde::{Deserialize, Serialize};

use crate::inference::sampler::adaptation::RunningCovariance;
use crate::math::cholesky;
use crate::random::Stream;

/// The inverse mass matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Metric {
    /// Variances.
    Diagonal(Vec<f64>),
    /// A covariance and its Cholesky factor, row by row.
    Dense {
        /// Covariance, n x n.
        covariance: Vec<f64>,
        /// Its factor, lower triangle.
        factor: Vec<f64>,
    },
}

impl Metric {
    /// Unit variances.
    pub fn unit(dimension: usize, dense: bool) -> Self {
        if dense {
            let mut covariance = vec![0.0; dimension * dimension];
            for i in 0..dimension {
                covariance[i * dimension + i] = 1.0;
            }
            Self::Dense { factor: covariance.clone(), covariance }
        } else {
            Self::Diagonal(vec![1.0; dimension])
        }
    }

    /// The metric of a covariance, n x n; `None` where it has no factor.
    pub fn of(covariance: &[f64], dimension: usize, dense: bool) -> Option<Self> {
        let mut factor = covariance.to_vec();
        cholesky::factor(&mut factor, dimension).ok()?;
        Some(if dense {
            Self::Dense { covariance: covariance.to_vec(), factor }
        } else {
            Self::Diagonal((0..dimension).map(|i| covariance[i * dimension + i]).collect())
        })
    }

    /// Entry of the covariance.
    fn entry(&self, i: usize, j: usize, dimension: usize) -> f64 {
        match self {
            Self::Diagonal(variances) if i == j => variances[i],
            Self::Diagonal(_) => 0.0,
            Self::Dense { covariance, .. } => covariance[i * dimension + j],
        }
    }

    /// Takes the covariance of a window of draws, shrunk with the weight of five draws towards what was known before: a
    /// covariance, else 1e-3 of the unit matrix (as Stan does). An estimate without a factor leaves the metric as it was.
    pub fn learn(&mut self, window: &RunningCovariance, earlier: Option<&Self>) {
        let count = window.count() as f64;
        if count < 2.0 {
            return;
        }
        let dimension = window.mean().len();
        let mut estimate = vec![0.0; dimension * dimension];
        window.covariance(&mut estimate);
        for value in &mut estimate {
            *value *= count / (count + 5.0);
        }
        for i in 0..dimension {
            for j in 0..dimension {
                let before = earlier.map_or(if i == j { 1e-3 } else { 0.0 }, |earlier| earlier.entry(i, j, dimension));
                estimate[i * dimension + j] += before * 5.0 / (count + 5.0);
            }
        }
        match self {
            Self::Diagonal(variances) => {
                for (i, variance) in variances.iter_mut().enumerate() {
                    *variance = estimate[i * dimension + i];
                }
            }
            Self::Dense { covariance, factor } => {
                let mut trial_factor = estimate.clone();
                if cholesky::factor(&mut trial_factor, dimension).is_ok() {
                    *factor = trial_factor;
                    *covariance = estimate;
                }
            }
        }
    }

    /// Draws a momentum.
    #[inline]
    pub fn draw_momentum(&self, stream: &mut Stream, momentum: &mut [f64]) {
        for value in momentum.iter_mut() {
            *value = stream.normal();
        }
        match self {
            Self::Diagonal(variances) => {
                for (p, variance) in momentum.iter_mut().zip(variances) {
                    *p /= variance.sqrt();
                }
            }
            Self::Dense { factor, .. } => cholesky::solve_lower_transposed(factor, momentum),
        }
    }

    /// Writes the velocity of a momentum.
    #[inline]
    pub fn velocity(&self, momentum: &[f64], velocity: &mut [f64]) {
        match self {
            Self::Diagonal(variances) => {
                for i in 0..velocity.len() {
                    velocity[i] = variances[i] * momentum[i];
                }
            }
            Self::Dense { covariance, .. } => {
                for (row, v) in covariance.chunks_exact(momentum.len()).zip(velocity) {
                    let mut sum = 0.0;
                    for (c, p) in row.iter().zip(momentum) {
                        sum += c * p;
                    }
                    *v = sum;
                }
            }
        }
    }
}
