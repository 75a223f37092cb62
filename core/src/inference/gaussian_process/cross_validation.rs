//! Scores of a form on values left out, with hyperparameters that did not see them.
//!
//! The values are dealt into folds in turn. The hyperparameters are fitted anew without a fold, and each of its values is then
//! predicted from all other values in closed form: so what is scored took no part in the choice of the hyperparameters, and the
//! cost is that of a few fits.

use super::fit::{Search, fit};
use super::process::{LeftOut, Process};
use super::{Form, GaussianProcessError, Training};
use crate::random::StreamKey;

/// Most folds.
const FOLDS: usize = 10;

/// Each value from all others. `start` are the hyperparameters fitted with all values, from which each fold's descent begins;
/// `bounds` are theirs.
///
/// # Errors
/// As [`fit`].
pub fn left_out(
    training: &Training,
    form: &Form,
    bounds: &[[f64; 2]],
    start: &[f64],
    key: &StreamKey,
) -> Result<Vec<LeftOut>, GaussianProcessError> {
    let n = training.len();
    if start.is_empty() {
        return Ok(Process::new(training.clone(), *form, &[])?.left_out());
    }
    let folds = FOLDS.min(n);
    let mut found: Vec<Option<LeftOut>> = vec![None; n];
    for fold in 0..folds {
        let kept: Vec<usize> = (0..n).filter(|i| i % folds != fold).collect();
        let search = Search { bounds: bounds.to_vec(), start: start.to_vec(), further: 0 };
        let hyperparameters = match fit(&training.some(&kept), form, &search, key) {
            Ok(fitted) => fitted.hyperparameters,
            // What is left says nothing of a process: the values that were taken out said it all.
            Err(GaussianProcessError::Constant { .. } | GaussianProcessError::TooFew { .. }) => start.to_vec(),
            Err(error) => return Err(error),
        };
        let left_out = Process::new(training.clone(), *form, &hyperparameters)?.left_out();
        (fold..n).step_by(folds).for_each(|i| found[i] = Some(left_out[i]));
    }
    Ok(found.into_iter().flatten().collect())
}

/// Sum of the log densities and its standard error (from their scatter; 0 of fewer than two).
pub fn score(log_densities: &[f64]) -> (f64, f64) {
    let n = log_densities.len() as f64;
    let sum: f64 = log_densities.iter().sum();
    if n < 2.0 {
        return (sum, 0.0);
    }
    let mean = sum / n;
    let square: f64 = log_densities.iter().map(|value| (value - mean) * (value - mean)).sum();
    (sum, (n * square / (n - 1.0)).sqrt())
}
