//! A rival hypothesis at its fit: what it predicts of a measurement, and how well its unknowns are known.

use nalgebra::DMatrix;

use crate::diagnosis::linearisation::signature::linearise;
use crate::diagnosis::{Problem, Refit};
use crate::inference::information::separation;
use crate::inference::likelihood::{Definition, Likelihood};
use crate::inference::target::{LeastSquares, Target};
use crate::math::cholesky;
use crate::math::sort::sort_by;
use crate::measurement::Measurement;

/// Whitened readings by which a measurement tells two rivals apart: those in which they differ most.
const MOST_READINGS: usize = 600;

/// What a rival predicts of a measurement.
pub(super) struct Predicted {
    pub likelihood: Likelihood,
    /// Whitened.
    pub residuals: Vec<f64>,
    /// Their derivatives, `residuals x unknowns of the fit`.
    pub jacobian: Vec<f64>,
}

/// A rival hypothesis at its fit.
pub(super) struct Rival<'a> {
    pub fit: &'a Refit,
    pub problem: Problem,
    /// Covariance of its unknowns after the old data.
    pub covariance: DMatrix<f64>,
}

impl<'a> Rival<'a> {
    pub fn new(problem: &Problem, fit: &'a Refit) -> Option<Self> {
        let with = problem.with(fit).ok()?;
        let likelihood = with.hypothesis(&[], 1.0).ok()?.likelihood(&with).ok()?;
        let linear = linearise(&likelihood, &fit.unknowns).ok()?;
        let n = linear.parameters();
        let free: Vec<usize> = (0..n).filter(|&i| linear.lower[i] < 0.0 && linear.upper[i] > 0.0).collect();
        let k = free.len();
        let mut information = vec![0.0; k * k];
        for row in linear.jacobian.chunks_exact(n.max(1)) {
            for (a, &i) in free.iter().enumerate() {
                for (b, &j) in free.iter().enumerate() {
                    information[a * k + b] += row[i] * row[j];
                }
            }
        }
        // What the data leave open is left to the box: a parameter cannot be less certain than its range.
        for (a, &i) in free.iter().enumerate() {
            let width = linear.upper[i] - linear.lower[i];
            if width.is_finite() && width > 0.0 {
                information[a * k + a] += 12.0 / (width * width);
            }
        }
        cholesky::factor(&mut information, k).ok()?;
        let inverse = cholesky::inverse(&information, k);
        let mut covariance = DMatrix::zeros(n, n);
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                covariance[(i, j)] = inverse[a * k + b];
            }
        }
        Some(Self { fit, problem: with, covariance })
    }

    /// Whitened predictions and derivatives of a measurement; rows are in the order of the likelihood's data. Readings of 0 make
    /// residuals that are minus the predictions.
    pub fn at(&self, measurement: &Measurement) -> Option<Predicted> {
        let problem = Problem { measurements: vec![measurement.clone()], ..self.problem.clone() };
        let likelihood = Likelihood::new(&Definition {
            model: &problem.model,
            priors: &problem.priors,
            parameters: &problem.parameters,
            measurements: &[measurement],
            input_errors: &problem.input_errors,
        })
        .ok()?;
        let likelihood = problem.informed(likelihood, &[]);
        let known = self.fit.by_name();
        let at: Vec<f64> = likelihood.names().iter().map(|name| known.get(name).copied()).collect::<Option<_>>()?;
        let linear = linearise(&likelihood, &at).ok()?;
        let (rows, n) = (likelihood.residual_count(), linear.parameters());
        // In the order of the fit's unknowns, some of which steady phases do not have.
        let all = self.fit.names.len();
        let mut jacobian = vec![0.0; rows * all];
        for (column, name) in likelihood.names().iter().enumerate() {
            let place = self.fit.names.iter().position(|known| known == name)?;
            for row in 0..rows {
                jacobian[row * all + place] = linear.jacobian[row * n + column];
            }
        }
        Some(Predicted { likelihood, residuals: linear.residuals[..rows].to_vec(), jacobian })
    }
}

impl Rival<'_> {
    /// Parameters of its model at the fit, in the model's order.
    pub fn full_parameters(&self, own: &Predicted) -> Option<Vec<f64>> {
        let known = self.fit.by_name();
        let at: Vec<f64> = own.likelihood.names().iter().map(|name| known.get(name).copied()).collect::<Option<_>>()?;
        Some(own.likelihood.full_parameters(&at))
    }
}

/// Squared distance of what the first predicts from what the second does, once that is fitted to it too: in some of the
/// readings.
pub(super) fn square(truth: &Predicted, rival: &Rival<'_>, other: &Predicted, rows: &[usize]) -> f64 {
    let mut rows = rows.to_vec();
    if rows.len() > MOST_READINGS {
        let apart = |row: usize| (truth.residuals[row] - other.residuals[row]).abs();
        sort_by(&mut rows, |&a, &b| apart(b).total_cmp(&apart(a)).then(a.cmp(&b)));
        rows.truncate(MOST_READINGS);
        rows.sort_unstable();
    }
    let n = rival.fit.names.len();
    let of = |residuals: &[f64]| -> Vec<f64> { rows.iter().map(|&row| residuals[row]).collect() };
    let slopes: Vec<f64> = rows.iter().flat_map(|row| &other.jacobian[row * n..(row + 1) * n]).copied().collect();
    // Whitened; the distance knows no sign.
    let noise: Vec<f64> =
        (0..rows.len() * rows.len()).map(|k| f64::from(u8::from(k % (rows.len() + 1) == 0))).collect();
    let mean = of(&other.residuals);
    let fitted =
        separation::Rival { mean: &mean, derivatives: &slopes, covariance: rival.covariance.as_slice(), parameters: n };
    separation::from_truth(&of(&truth.residuals), &fitted, &noise).map_or(0.0, |own| own.distance_squared)
}
