//! Moves of particles that learn from other particles.
//!
//! - a random walk with their covariance;
//! - a shrinking move `m + sqrt(1 - b^2) (z - m) + b L u`, which leaves the normal density with their mean and covariance
//!   as it is and is nearly independent for `b` near one (preconditioned Crank-Nicolson; Cotter, Roberts, Stuart & White
//!   2013): for posteriors close to normal it forgets in a few moves;
//! - a step along the difference of two of them (ter Braak 2006), whose long form jumps from mode to mode.

use crate::inference::sampler::adaptation::RunningCovariance;
use crate::inference::sampler::smc::Particle;
use crate::math::cholesky;
use crate::random::Stream;

/// Kinds of moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Shrink,
    Walk,
    Difference,
    LongDifference,
}

impl Kind {
    /// The kind of a stage's n-th move.
    pub(super) fn of(number: u64) -> Self {
        match number % 6 {
            0 | 3 => Self::Shrink,
            1 | 4 => Self::Walk,
            2 => Self::Difference,
            _ => Self::LongDifference,
        }
    }

    pub(super) fn needs_covariance(self) -> bool {
        matches!(self, Self::Shrink | Self::Walk)
    }
}

/// A proposal, and the normal density that proposals are drawn with.
pub(super) struct Proposal {
    /// Where to go.
    pub(super) coordinates: Vec<f64>,
    /// The last draw with the covariance, about zero.
    pub(super) normals: Vec<f64>,
    standard: Vec<f64>,
    mean: Vec<f64>,
    factor: Vec<f64>,
    running: RunningCovariance,
}

impl Proposal {
    pub(super) fn new(dimension: usize) -> Self {
        let zeros = || vec![0.0; dimension];
        Self {
            coordinates: zeros(),
            normals: zeros(),
            standard: zeros(),
            mean: zeros(),
            factor: vec![0.0; dimension * dimension],
            running: RunningCovariance::new(dimension),
        }
    }

    /// Takes mean and covariance from particles; variances alone where copies leave the covariance singular.
    pub(super) fn learn(&mut self, particles: &[Particle]) {
        let n = self.mean.len();
        self.running.reset();
        for particle in particles {
            self.running.add(&particle.coordinates);
        }
        self.mean.copy_from_slice(self.running.mean());
        for attempt in 0..2 {
            self.running.covariance(&mut self.factor);
            for i in 0..n {
                for j in 0..n {
                    let entry = &mut self.factor[i * n + j];
                    if i == j {
                        *entry = *entry * (1.0 + 1e-9) + 1e-16;
                    } else if attempt == 1 {
                        *entry = 0.0;
                    }
                }
            }
            if cholesky::factor(&mut self.factor, n).is_ok() {
                return;
            }
        }
    }

    /// Draws `normals` with the covariance.
    pub(super) fn draw(&mut self, stream: &mut Stream) {
        for value in &mut self.standard {
            *value = stream.normal();
        }
        cholesky::multiply(&self.factor, &self.standard, &mut self.normals);
    }

    /// Writes a shrinking move of strength `b` from a point; the log ratio of the normal density here over there.
    pub(super) fn shrink(&mut self, here: &[f64], strength: f64, stream: &mut Stream) -> f64 {
        self.draw(stream);
        let keep = (1.0 - strength * strength).max(0.0).sqrt();
        for i in 0..here.len() {
            self.coordinates[i] = self.mean[i] + keep * (here[i] - self.mean[i]) + strength * self.normals[i];
        }
        0.5 * (self.distance(None) - self.distance(Some(here)))
    }

    /// Squared Mahalanobis distance of a point (of the proposal where none is given) from the mean.
    fn distance(&mut self, point: Option<&[f64]>) -> f64 {
        let point = point.unwrap_or(&self.coordinates);
        for i in 0..point.len() {
            self.standard[i] = point[i] - self.mean[i];
        }
        cholesky::solve_lower(&self.factor, &mut self.standard);
        self.standard.iter().map(|u| u * u).sum()
    }
}
