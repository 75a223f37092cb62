//! A process with given hyperparameters: what it expects at new points, draws, and each value from the others.
//!
//! With the trend's functions `h`, `u = h(x) - H' K^-1 k(x)`: mean `k' P r`-form `k' K^-1 (r - H b) + h' b`, variance
//! `k(x, x) - k' K^-1 k + u' A^-1 u` (Rasmussen & Williams 2006, eq. 2.25, 2.26, 2.42). A value from the others: mean
//! `r_i - (P r)_i / P_ii`, variance `1 / P_ii`, noise included (eq. 5.12; with a trend Dubrule 1983).

use super::kernel::distance_square;
use super::marginal::Factored;
use super::{Form, GaussianProcessError, Named, Training};
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::math::special::ln_normal_density;
use crate::random::Stream;

/// A process with values.
#[derive(Clone, Debug)]
pub struct Process {
    training: Training,
    form: Form,
    named: Named,
    pub(super) factored: Factored,
}

/// What is expected at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Mean.
    pub mean: f64,
    /// Variance of trend and smooth part.
    pub variance: f64,
    /// Variance of the scatter, which comes on top.
    pub scatter: f64,
}

impl Expected {
    /// Standard deviation, scatter included.
    pub fn sd(&self) -> f64 {
        (self.variance + self.scatter).max(0.0).sqrt()
    }
}

/// What is expected at a point as a function of the values: `mean = weights' values`.
#[derive(Clone, Debug, PartialEq)]
pub struct Functional {
    /// Weight of each value.
    pub weights: Vec<f64>,
    /// Variance of trend and smooth part.
    pub variance: f64,
    /// Variance of the scatter.
    pub scatter: f64,
}

/// A value as the others predict it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// Mean.
    pub mean: f64,
    /// Standard deviation, noise included.
    pub sd: f64,
    /// Logarithm of the density at the value.
    pub log_density: f64,
    /// (value - mean) / sd.
    pub standardised: f64,
}

impl Process {
    /// With these hyperparameters (logarithms, [`Form::hyperparameters`]).
    ///
    /// # Errors
    /// As [`Factored::new`].
    pub fn new(training: Training, form: Form, hyperparameters: &[f64]) -> Result<Self, GaussianProcessError> {
        let factored = Factored::new(&training, &form, hyperparameters)?;
        Ok(Self { named: form.named(hyperparameters), training, form, factored })
    }

    /// Logarithm of the marginal likelihood.
    pub fn log_likelihood(&self) -> f64 {
        self.factored.log_likelihood()
    }

    /// What it consists of.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// The hyperparameters.
    pub fn named(&self) -> &Named {
        &self.named
    }

    /// Coefficients of the trend: constant, then a slope for each input.
    pub fn trend(&self) -> &[f64] {
        &self.factored.beta
    }

    /// The points and values.
    pub fn training(&self) -> &Training {
        &self.training
    }

    /// Covariances of the smooth part between a point and those with values.
    fn column(&self, point: &[f64]) -> Vec<f64> {
        let of = |i: usize| match self.form.kernel {
            Some(kernel) => {
                self.named.variance
                    * kernel.correlation(distance_square(point, self.training.point(i), &self.named.lengths)).0
            }
            None => 0.0,
        };
        (0..self.training.len()).map(of).collect()
    }

    /// `L^-1 k`, and `R^-1 u` with `A = R R'`.
    pub(super) fn whitened(&self, point: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut column = self.column(point);
        cholesky::solve_lower(&self.factored.lower, &mut column);
        let mut unseen = self.form.trend.at(point);
        for (u, basis) in unseen.iter_mut().zip(&self.factored.basis) {
            *u -= basis.iter().zip(&column).map(|(h, k)| h * k).sum::<f64>();
        }
        cholesky::solve_lower(&self.factored.coefficients, &mut unseen);
        (column, unseen)
    }

    /// What is expected at a point (as many numbers as the points with values have).
    pub fn at(&self, point: &[f64]) -> Expected {
        let column = self.column(point);
        let smooth: f64 = column.iter().zip(&self.factored.weights).map(|(k, w)| k * w).sum();
        let trend: f64 = self.form.trend.at(point).iter().zip(&self.factored.beta).map(|(h, b)| h * b).sum();
        let (column, unseen) = self.whitened(point);
        let square = |list: &[f64]| list.iter().map(|x| x * x).sum::<f64>();
        let variance = (self.named.variance - square(&column)).max(0.0) + square(&unseen);
        Expected { mean: trend + smooth, variance, scatter: self.named.scatter }
    }

    /// The same as a function of the values.
    pub fn functional(&self, point: &[f64]) -> Functional {
        let (column, unseen) = self.whitened(point);
        let square = |list: &[f64]| list.iter().map(|x| x * x).sum::<f64>();
        let variance = (self.named.variance - square(&column)).max(0.0) + square(&unseen);
        // K^-1 (k + H A^-1 u).
        let mut weights = column;
        let mut coefficients = unseen;
        cholesky::solve_lower_transposed(&self.factored.coefficients, &mut coefficients);
        for (basis, coefficient) in self.factored.basis.iter().zip(&coefficients) {
            for (weight, h) in weights.iter_mut().zip(basis) {
                *weight += h * coefficient;
            }
        }
        cholesky::solve_lower_transposed(&self.factored.lower, &mut weights);
        Functional { weights, variance, scatter: self.named.scatter }
    }

    /// Means and covariance (row after row) of trend and smooth part at several points.
    pub fn together(&self, points: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
        let n = points.len();
        let means = points.iter().map(|point| self.at(point).mean).collect();
        let whitened: Vec<(Vec<f64>, Vec<f64>)> = points.iter().map(|point| self.whitened(point)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let covariance = crate::math::dense::square(n, |i, j| {
            let before = self.form.kernel.map_or(0.0, |kernel| {
                self.named.variance * kernel.between(&points[i], &points[j], &self.named.lengths)
            });
            before - dot(&whitened[i].0, &whitened[j].0) + dot(&whitened[i].1, &whitened[j].1)
        });
        (means, covariance)
    }

    /// A draw of trend and smooth part at several points together.
    ///
    /// # Errors
    /// A covariance that rounding leaves indefinite.
    pub fn draw(&self, points: &[Vec<f64>], stream: &mut Stream) -> Result<Vec<f64>, GaussianProcessError> {
        let n = points.len();
        let (mut draw, mut covariance) = self.together(points);
        // Points beside those with values are all but known: rounding must not make their variances negative.
        let largest = (0..n).map(|i| covariance[i * n + i]).fold(0.0, f64::max);
        for i in 0..n {
            covariance[i * n + i] += 1e-10 * largest.max(self.named.variance).max(f64::MIN_POSITIVE);
        }
        cholesky::factor(&mut covariance, n).map_err(|_| GaussianProcessError::Indefinite)?;
        let normals: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
        let mut deviations = vec![0.0; n];
        cholesky::multiply(&covariance, &normals, &mut deviations);
        draw.iter_mut().zip(deviations).for_each(|(value, deviation)| *value += deviation);
        Ok(draw)
    }

    /// Each value from all others, by the hyperparameters as they are.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let n = self.training.len();
        let projected = self.factored.projected();
        let left_out = |i: usize| {
            let precision = projected[i * n + i];
            let sd = (1.0 / precision).sqrt();
            let standardised = self.factored.weights[i] / precision / sd;
            let mean = self.training.values()[i] - self.factored.weights[i] / precision;
            LeftOut { mean, sd, log_density: ln_normal_density(standardised) - ln(sd), standardised }
        };
        (0..n).map(left_out).collect()
    }

    /// `P` in full (n x n): the precision of the values with the trend's coefficients unknown.
    pub fn precision(&self) -> Vec<f64> {
        let n = self.training.len();
        let mut precision = self.factored.projected();
        for i in 0..n {
            for j in 0..i {
                precision[j * n + i] = precision[i * n + j];
            }
        }
        precision
    }

    /// Distance from a point to the nearest one with a value, in lengths; without a kernel 0.
    pub fn nearest(&self, point: &[f64]) -> f64 {
        if self.form.kernel.is_none() {
            return 0.0;
        }
        let square = |i: usize| distance_square(point, self.training.point(i), &self.named.lengths);
        (0..self.training.len()).map(square).fold(f64::INFINITY, f64::min).sqrt()
    }
}
