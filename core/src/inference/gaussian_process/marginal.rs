//! Logarithm of the marginal likelihood, with its exact gradient.
//!
//! With the covariance `K`, the trend's functions `H` (q columns) and `A = H' K^-1 H`, under a flat prior of the coefficients
//! `ln p = -r' P r / 2 - ln|K| / 2 - ln|A| / 2 - (n - q) / 2 ln 2 pi`, `P = K^-1 - K^-1 H A^-1 H' K^-1` (Rasmussen & Williams
//! 2006, eq. 2.45). Its slope is `((P r)' dK (P r) - tr(P dK)) / 2` (eq. 5.9, `P` in place of `K^-1`).
//!
//! Scalar products run over rows that lie in one piece, by interleaved sums of a fixed order.

use super::triangular::{dot, factor, inverse, solve_lower};
use super::{Form, GaussianProcessError, Kernel, Training};
use crate::math::cholesky;
use crate::math::functions::ln;

/// `ln 2 pi`.
const LN_TWO_PI: f64 = 1.837_877_066_409_345_5;

/// The values' covariance factored, and what follows from it.
#[derive(Clone, Debug)]
pub struct Factored {
    /// Lower factor `L` of `K`, row after row; what lies above the diagonal is not used.
    pub(super) lower: Vec<f64>,
    /// `L^-1 H` by coefficient.
    pub(super) basis: Vec<Vec<f64>>,
    /// Factor of `A`.
    pub(super) coefficients: Vec<f64>,
    /// Coefficients of the trend.
    pub(super) beta: Vec<f64>,
    /// `P r`.
    pub(super) weights: Vec<f64>,
    /// Logarithm of the marginal likelihood.
    pub(super) log_likelihood: f64,
}

/// Covariance of the smooth part over the pairs `(i, j < i)`, and its slopes over the same divided by each input's part.
struct Smooth {
    variance: f64,
    inverse_squares: Vec<f64>,
    covariances: Vec<f64>,
    slopes: Vec<f64>,
}

fn smooth(training: &Training, kernel: Kernel, variance: f64, lengths: &[f64]) -> Smooth {
    let pairs = training.squares.first().map_or(training.len() * training.len().saturating_sub(1) / 2, Vec::len);
    let inverse_squares: Vec<f64> = lengths.iter().map(|length| 1.0 / (length * length)).collect();
    let mut squares = vec![0.0; pairs];
    for (input, weight) in training.squares.iter().zip(&inverse_squares) {
        for (square, part) in squares.iter_mut().zip(input) {
            *square += part * weight;
        }
    }
    let mut slopes = squares.clone();
    for (value, slope) in squares.iter_mut().zip(&mut slopes) {
        let (correlation, change) = kernel.correlation(*value);
        *value = variance * correlation;
        *slope = variance * change;
    }
    Smooth { variance, inverse_squares, covariances: squares, slopes }
}

impl Factored {
    /// At these hyperparameters. Cost: n^3 / 6 operations.
    ///
    /// # Errors
    /// A covariance that is not positive definite, coefficients that the points do not tell apart.
    pub fn new(training: &Training, form: &Form, hyperparameters: &[f64]) -> Result<Self, GaussianProcessError> {
        Self::with_smooth(training, form, hyperparameters).map(|(factored, _)| factored)
    }

    fn with_smooth(
        training: &Training,
        form: &Form,
        hyperparameters: &[f64],
    ) -> Result<(Self, Option<Smooth>), GaussianProcessError> {
        let (n, wanted) = (training.len(), form.hyperparameters(training.inputs()));
        if hyperparameters.len() != wanted {
            let (what, found) = ("the list of hyperparameters", hyperparameters.len());
            return Err(GaussianProcessError::Shape { what, found, expected: wanted });
        }
        let named = form.named(hyperparameters);
        let smooth = form.kernel.map(|kernel| smooth(training, kernel, named.variance, &named.lengths));
        let mut lower = vec![0.0; n * n];
        let mut first = 0;
        for i in 0..n {
            if let Some(smooth) = &smooth {
                lower[i * n..i * n + i].copy_from_slice(&smooth.covariances[first..first + i]);
            }
            first += i;
            lower[i * n + i] = named.variance + named.scatter + training.noise[i];
        }
        factor(&mut lower, n)?;
        let columns = form.trend.coefficients(training.inputs());
        let mut basis = vec![Vec::with_capacity(n); columns];
        for i in 0..n {
            for (column, value) in basis.iter_mut().zip(form.trend.at(training.point(i))) {
                column.push(value);
            }
        }
        basis.iter_mut().for_each(|column| solve_lower(&lower, column));
        let mut coefficients = vec![0.0; columns * columns];
        for a in 0..columns {
            for b in 0..columns {
                coefficients[a * columns + b] = dot(&basis[a], &basis[b]);
            }
        }
        // What is left of a column beside the others is rounding where it is this small.
        let largest = (0..columns).map(|a| coefficients[a * columns + a]).fold(0.0, f64::max);
        let is_regular = cholesky::factor(&mut coefficients, columns).is_ok()
            && (0..columns).all(|a| {
                let left = coefficients[a * columns + a];
                left * left > 1e-13 * largest
            });
        if !is_regular || columns > n {
            return Err(GaussianProcessError::Trend { points: n });
        }
        let log_determinant: f64 = (0..n).map(|i| 2.0 * ln(lower[i * n + i])).sum();
        let mut factored =
            Self { lower, basis, coefficients, beta: Vec::new(), weights: Vec::new(), log_likelihood: 0.0 };
        let (beta, left) = factored.whitened(training.values());
        let square: f64 = left.iter().map(|e| e * e).sum();
        factored.log_likelihood = -0.5
            * (square
                + log_determinant
                + cholesky::log_determinant(&factored.coefficients, columns)
                + (n - columns) as f64 * LN_TWO_PI);
        factored.weights = left;
        cholesky::solve_lower_transposed(&factored.lower, &mut factored.weights);
        factored.beta = beta;
        if !factored.log_likelihood.is_finite() {
            return Err(GaussianProcessError::Indefinite);
        }
        Ok((factored, smooth))
    }

    /// Coefficients of the trend through values, and `L^-1` of what it leaves of them.
    pub(super) fn whitened(&self, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut left = values.to_vec();
        solve_lower(&self.lower, &mut left);
        let mut beta: Vec<f64> = self.basis.iter().map(|column| dot(column, &left)).collect();
        cholesky::solve(&self.coefficients, &mut beta);
        for (column, coefficient) in self.basis.iter().zip(&beta) {
            for (e, h) in left.iter_mut().zip(column) {
                *e -= coefficient * h;
            }
        }
        (beta, left)
    }

    /// Logarithm of the marginal likelihood.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihood
    }

    /// Slopes of the marginal likelihood's logarithm with the values, `-P r`.
    pub fn slopes_with_values(&self) -> impl Iterator<Item = f64> + '_ {
        self.weights.iter().map(|weight| -weight)
    }

    /// Rows up to the diagonal of `P` (n x n). Cost: n^3 / 3.
    pub fn projected(&self) -> Vec<f64> {
        let (n, columns) = (self.weights.len(), self.basis.len());
        let mut projected = inverse(&self.lower, n);
        let mut rows: Vec<Vec<f64>> = self.basis.clone();
        for row in &mut rows {
            // K^-1 H.
            cholesky::solve_lower_transposed(&self.lower, row);
        }
        // R^-1 of it with A = R R': then what is taken off is a product of its columns.
        for i in 0..n {
            let mut entry: Vec<f64> = (0..columns).map(|a| rows[a][i]).collect();
            cholesky::solve_lower(&self.coefficients, &mut entry);
            entry.into_iter().enumerate().for_each(|(a, value)| rows[a][i] = value);
        }
        for row in &rows {
            for i in 0..n {
                for j in 0..=i {
                    projected[i * n + j] -= row[i] * row[j];
                }
            }
        }
        projected
    }
}

/// Logarithm of the marginal likelihood at logarithmic hyperparameters ([`Form::hyperparameters`]); written into `gradient`
/// are its slopes with each of them. Cost: n^3 / 2 operations.
///
/// # Errors
/// As [`Factored::new`].
pub fn with_gradient(
    training: &Training,
    form: &Form,
    hyperparameters: &[f64],
    gradient: &mut [f64],
) -> Result<f64, GaussianProcessError> {
    factored_with_gradient(training, form, hyperparameters, gradient).map(|factored| factored.log_likelihood)
}

/// As [`with_gradient`], with all that follows from the factored covariance.
///
/// # Errors
/// As [`Factored::new`].
pub fn factored_with_gradient(
    training: &Training,
    form: &Form,
    hyperparameters: &[f64],
    gradient: &mut [f64],
) -> Result<Factored, GaussianProcessError> {
    let (factored, smooth) = Factored::with_smooth(training, form, hyperparameters)?;
    let n = training.len();
    let mut weight = factored.projected();
    for i in 0..n {
        let own = factored.weights[i];
        for (entry, other) in weight[i * n..=i * n + i].iter_mut().zip(&factored.weights) {
            *entry = own * other - *entry;
        }
    }
    let trace: f64 = (0..n).map(|i| weight[i * n + i]).sum();
    gradient.fill(0.0);
    if let Some(smooth) = &smooth {
        let mut first = 0;
        let (mut along, mut products) = (0.0, vec![0.0; n]);
        for i in 0..n {
            let row = &weight[i * n..i * n + i];
            along += dot(row, &smooth.covariances[first..first + i]);
            let slopes = &smooth.slopes[first..first + i];
            products.iter_mut().zip(row).zip(slopes).for_each(|((product, weight), slope)| *product = weight * slope);
            for (input, squares) in training.squares.iter().enumerate() {
                gradient[1 + input] += dot(&products[..i], &squares[first..first + i]) * smooth.inverse_squares[input];
            }
            first += i;
        }
        gradient[0] = along + 0.5 * smooth.variance * trace;
    }
    if form.scatter
        && let Some(last) = gradient.last_mut()
    {
        *last = 0.5 * form.named(hyperparameters).scatter * trace;
    }
    Ok(factored)
}
