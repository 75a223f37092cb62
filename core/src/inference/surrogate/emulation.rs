//! The Gaussian process of an output, and how well it predicts runs that were left out.
//!
//! A trend that is linear in the coordinates, a smooth part (squared exponential or Matern 5/2, whichever has the higher
//! marginal likelihood) and scatter, which takes the model's own numerical noise. Where runs left out lie further from what
//! is predicted than its standard deviation says, that deviation is widened by a factor: it is what results carry.

use serde::{Deserialize, Serialize};

use crate::inference::gaussian_process::cross_validation::left_out;
use crate::inference::gaussian_process::fit::{Search, fit};
use crate::inference::gaussian_process::process::Process;
use crate::inference::gaussian_process::{Form, GaussianProcessError, Kernel, Training, Trend};
use crate::math::functions::ln;
use crate::random::StreamKey;

/// Descents from further starts.
const FURTHER: usize = 3;
/// Smallest variance of the scatter against that of the values: models are computed to about six digits and better.
const LEAST_SCATTER: f64 = 1e-11;
/// Share of its size by which a value varies at least, where it is no constant.
const CONSTANT: f64 = 1e-12;

/// Errors of runs that were left out one by one; hyperparameters did not see them (ten folds).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LeftOutError {
    /// Root of the mean square, SI.
    pub rms: f64,
    /// The largest, SI.
    pub worst: f64,
    /// Root of the mean square of errors in their predicted standard deviations: about 1 where these are right.
    pub standardised: f64,
    /// Each error, in the order of the runs, SI.
    pub errors: Vec<f64>,
}

/// The process of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emulation {
    /// Covariance of the smooth part; `None` where all runs gave the same value.
    pub kernel: Option<Kernel>,
    /// Logarithms of the hyperparameters.
    pub hyperparameters: Vec<f64>,
    /// Standard deviation of the output over the runs, SI.
    pub spread: f64,
    /// Errors of runs left out.
    pub left_out: LeftOutError,
    /// Factor on the predicted standard deviation, at least 1.
    pub factor: f64,
    /// Anchors of the error: coordinates of points at which it is a parameter of its own.
    pub anchors: Vec<Vec<f64>>,
}

fn form(kernel: Kernel) -> Form {
    Form { kernel: Some(kernel), trend: Trend::Linear, scatter: true }
}

fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt()
}

impl Emulation {
    /// Fits values at points (`points x axes`).
    ///
    /// # Errors
    /// Too few points, or points that tell no process apart.
    pub fn fit(axes: usize, points: &[f64], values: Vec<f64>, key: &StreamKey) -> Result<Self, GaussianProcessError> {
        let n = values.len();
        let spread = spread(&values);
        let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        if spread <= CONSTANT * largest {
            let left_out = LeftOutError { errors: vec![0.0; n], ..LeftOutError::default() };
            return Ok(Self {
                kernel: None,
                hyperparameters: Vec::new(),
                spread: 0.0,
                left_out,
                factor: 1.0,
                anchors: Vec::new(),
            });
        }
        let training = Training::new(axes, points.to_vec(), values, vec![0.0; n])?;
        let mut best = None;
        let mut failed = GaussianProcessError::Indefinite;
        for kernel in [Kernel::SquaredExponential, Kernel::Matern52] {
            let form = form(kernel);
            let mut search = Search::usual(&training, &form, FURTHER);
            if let Some(last) = search.bounds.last_mut() {
                last[0] = ln(training.mean_square(form.trend)) + ln(LEAST_SCATTER);
            }
            if let Some(last) = search.start.last_mut() {
                *last = ln(training.mean_square(form.trend)) + ln(1e-8);
            }
            match fit(&training, &form, &search, key) {
                Ok(found) => {
                    let likelihood = found.log_likelihood;
                    if best.as_ref().is_none_or(|(_, _, _, other)| likelihood > *other) {
                        best = Some((kernel, found.hyperparameters, search.bounds, likelihood));
                    }
                }
                Err(error) => failed = error,
            }
        }
        let (kernel, hyperparameters, bounds, _) = best.ok_or(failed)?;
        let left_out = left_out(&training, &form(kernel), &bounds, &hyperparameters, key)?;
        let errors: Vec<f64> = left_out.iter().zip(training.values()).map(|(own, value)| own.mean - value).collect();
        let mean_square = |list: &[f64]| list.iter().map(|x| x * x).sum::<f64>() / list.len().max(1) as f64;
        let standardised: Vec<f64> = left_out.iter().map(|own| own.standardised).collect();
        let left_out = LeftOutError {
            rms: mean_square(&errors).sqrt(),
            worst: errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs())),
            standardised: mean_square(&standardised).sqrt(),
            errors,
        };
        let factor = left_out.standardised.max(1.0);
        Ok(Self { kernel: Some(kernel), hyperparameters, spread, left_out, factor, anchors: Vec::new() })
    }

    /// The process through the values; `None` of a constant.
    ///
    /// # Errors
    /// Numbers that do not belong to the fit.
    pub fn process(
        &self,
        axes: usize,
        points: &[f64],
        values: &[f64],
    ) -> Result<Option<Process>, GaussianProcessError> {
        let Some(kernel) = self.kernel else { return Ok(None) };
        let training = Training::new(axes, points.to_vec(), values.to_vec(), vec![0.0; values.len()])?;
        Process::new(training, form(kernel), &self.hyperparameters).map(Some)
    }
}
