//! A target's posterior as an objective over natural coordinates: the logarithm of parameters whose prior is normal or
//! uniform in the logarithm, the parameter itself for all others. There, normal priors are residual rows and uniform
//! priors are bounds; only a triangular prior is a penalty of its own.

use crate::inference::estimate::optimise::{Bounds, Objective};
use crate::inference::posterior::Work;
use crate::inference::prior::transform::{Transform, TransformError};
use crate::inference::target::{LeastSquares, Rejected};
use crate::math::functions::{exp, ln};
use crate::random::Distribution;
use crate::watch;

/// The negative log posterior of a target, constants of the priors left out.
pub struct NaturalObjective<'a, T: LeastSquares> {
    target: &'a T,
    workspace: T::Workspace,
    logarithmic: Vec<bool>,
    prior_rows: Vec<usize>,
    parameters: Vec<f64>,
    /// What was spent so far.
    pub work: Work,
}

impl<'a, T: LeastSquares> NaturalObjective<'a, T> {
    /// The objective of a target.
    ///
    /// # Errors
    /// [`TransformError`] for a prior without spread.
    pub fn new(target: &'a T) -> Result<Self, TransformError> {
        let priors = target.priors();
        for (index, prior) in priors.iter().enumerate() {
            Transform::new(prior, index)?;
        }
        let logarithmic = priors
            .iter()
            .map(|prior| matches!(prior, Distribution::LogNormal { .. } | Distribution::LogUniform { .. }))
            .collect();
        let is_row = |prior: &Distribution| {
            matches!(
                prior,
                Distribution::Normal { .. } | Distribution::LogNormal { .. } | Distribution::HalfNormal { .. }
            )
        };
        let prior_rows = (0..priors.len()).filter(|&i| is_row(&priors[i])).collect();
        Ok(Self {
            target,
            workspace: target.workspace(),
            logarithmic,
            prior_rows,
            parameters: vec![0.0; priors.len()],
            work: Work::default(),
        })
    }

    /// Whether a coordinate is the parameter's logarithm.
    pub fn logarithmic(&self) -> &[bool] {
        &self.logarithmic
    }

    /// Number of residuals of the data, which come before those of the priors.
    pub fn data_rows(&self) -> usize {
        self.target.residual_count()
    }

    /// Bounds of the coordinates.
    pub fn bounds(&self) -> Bounds {
        let ends = |pick: fn((f64, f64)) -> f64| {
            self.target
                .priors()
                .iter()
                .zip(&self.logarithmic)
                .map(|(prior, logarithmic)| {
                    let end = pick(prior.support());
                    if *logarithmic { ln(end) } else { end }
                })
                .collect()
        };
        Bounds { lower: ends(|s| s.0), upper: ends(|s| s.1) }
    }

    /// Coordinates of parameters (SI).
    pub fn coordinates(&self, parameters: &[f64]) -> Vec<f64> {
        parameters.iter().zip(&self.logarithmic).map(|(x, log)| if *log { ln(*x) } else { *x }).collect()
    }

    /// Parameters (SI) of coordinates.
    pub fn parameters(&self, coordinates: &[f64]) -> Vec<f64> {
        coordinates.iter().zip(&self.logarithmic).map(|(c, log)| if *log { exp(*c) } else { *c }).collect()
    }

    /// Log density of the prior over the coordinates.
    pub fn log_prior(&self, coordinates: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (i, prior) in self.target.priors().iter().enumerate() {
            sum += if self.logarithmic[i] {
                let value = exp(coordinates[i]);
                // At a bound the exponential may fall outside by rounding.
                let (lower, upper) = prior.support();
                prior.log_density(value.max(lower).min(upper)) + coordinates[i]
            } else {
                prior.log_density(coordinates[i])
            };
        }
        sum
    }

    /// Log density of the triangular priors alone.
    pub fn triangular_log_density(&self, coordinates: &[f64]) -> f64 {
        -self.triangles(coordinates, None)
    }

    fn take(&mut self, coordinates: &[f64]) {
        for i in 0..coordinates.len() {
            self.parameters[i] = if self.logarithmic[i] {
                let (lower, upper) = self.target.priors()[i].support();
                exp(coordinates[i]).max(lower).min(upper)
            } else {
                coordinates[i]
            };
        }
    }

    /// Standardised deviation of a coordinate from its prior's centre, and its slope.
    fn prior_row(&self, i: usize, coordinate: f64) -> (f64, f64) {
        match self.target.priors()[i] {
            Distribution::Normal { mean, sd, .. } => ((coordinate - mean) / sd, 1.0 / sd),
            Distribution::LogNormal { median, factor } => ((coordinate - ln(median)) / ln(factor), 1.0 / ln(factor)),
            Distribution::HalfNormal { scale } => (coordinate / scale, 1.0 / scale),
            _ => (0.0, 0.0),
        }
    }

    /// Penalty of the triangular priors; with its gradient.
    fn triangles(&self, coordinates: &[f64], mut gradient: Option<&mut [f64]>) -> f64 {
        let mut penalty = 0.0;
        for (i, prior) in self.target.priors().iter().enumerate() {
            if matches!(prior, Distribution::Triangular { .. }) {
                penalty -= prior.log_density(coordinates[i]);
                if let Some(gradient) = gradient.as_deref_mut() {
                    gradient[i] -= prior.log_density_derivative(coordinates[i]);
                }
            }
        }
        penalty
    }

    fn count(&mut self, rejected: &Rejected) {
        self.work.rejections.count(rejected);
    }
}

impl<T: LeastSquares> Objective for NaturalObjective<'_, T> {
    fn dimension(&self) -> usize {
        self.logarithmic.len()
    }

    fn rows(&self) -> usize {
        self.data_rows() + self.prior_rows.len()
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        watch::check();
        self.take(x);
        self.work.likelihoods += 1;
        let data = self.data_rows();
        let offset = match self.target.residuals(&self.parameters, &mut self.workspace, &mut residuals[..data]) {
            Ok(offset) => offset,
            Err(rejected) => {
                self.count(&rejected);
                return None;
            }
        };
        for (row, &i) in self.prior_rows.iter().enumerate() {
            residuals[data + row] = self.prior_row(i, x[i]).0;
        }
        Some(self.triangles(x, None) - offset)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        watch::check();
        self.take(x);
        self.work.gradients += 1;
        let (data, n) = (self.data_rows(), x.len());
        let answer = self.target.jacobian(
            &self.parameters,
            &mut self.workspace,
            &mut residuals[..data],
            &mut jacobian[..data * n],
            penalty_gradient,
        );
        let offset = match answer {
            Ok(offset) => offset,
            Err(rejected) => {
                self.count(&rejected);
                return None;
            }
        };
        for i in 0..n {
            let slope = if self.logarithmic[i] { self.parameters[i] } else { 1.0 };
            penalty_gradient[i] *= -slope;
            if self.logarithmic[i] {
                for row in 0..data {
                    jacobian[row * n + i] *= slope;
                }
            }
        }
        jacobian[data * n..].fill(0.0);
        for (row, &i) in self.prior_rows.iter().enumerate() {
            let (residual, slope) = self.prior_row(i, x[i]);
            residuals[data + row] = residual;
            jacobian[(data + row) * n + i] = slope;
        }
        Some(self.triangles(x, Some(penalty_gradient)) - offset)
    }
}
