//! How far a discrepancy that is free beside the parameters would have moved them.
//!
//! A calibration that leaves the discrepancy out gives the parameters what both of them explain (Kennedy & O'Hagan 2001;
//! Brynjarsdottir & O'Hagan 2014, Inverse Problems 30, 114007). To first order about its posterior, with the slopes `J` of the
//! readings, their noise `S`, the discrepancy's covariance `K` and the residuals `r`: the precision `C^-1` of the parameters
//! becomes `C^-1 - J' S^-1 J + J' (S + K)^-1 J`, and their mean moves by its inverse times `J' (S + K)^-1 r - J' S^-1 r`, as
//! the prior's pull balances `J' S^-1 r` where the calibration ended.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// What the readings of a sensor say of the parameters: with their noise alone, and with the discrepancy free.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Information {
    /// `J' S^-1 J` (p x p).
    pub noise: Vec<f64>,
    /// `J' (S + K)^-1 J`.
    pub free: Vec<f64>,
    /// `J' S^-1 r`.
    pub noise_pull: Vec<f64>,
    /// `J' (S + K)^-1 r`.
    pub free_pull: Vec<f64>,
}

/// What becomes of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Standard deviation of the posterior as calibrated.
    pub sd: f64,
    /// The same with the discrepancy free.
    pub free_sd: f64,
    /// By how much its mean moves.
    pub shift: f64,
    /// Share of what these readings say of it alone that the discrepancy could say as well, 0 to 1.
    pub absorbed: f64,
}

impl Information {
    /// `precision` is that of the readings with the discrepancy (n x n), `noise` their variances, all above 0; `slopes` are
    /// those of the predicted readings, reading by reading (n x p).
    pub fn new(precision: &[f64], noise: &[f64], slopes: &[Vec<f64>], residuals: &[f64]) -> Self {
        let (n, p) = (residuals.len(), slopes.first().map_or(0, Vec::len));
        let weighted = |of: &dyn Fn(usize, usize) -> f64, right: &dyn Fn(usize) -> f64, parameter: usize| -> f64 {
            let row = |i: usize| slopes[i][parameter] * (0..n).map(|j| of(i, j) * right(j)).sum::<f64>();
            (0..n).map(row).sum()
        };
        let full = |i: usize, j: usize| precision[i * n + j];
        let diagonal = |i: usize, j: usize| if i == j { 1.0 / noise[i] } else { 0.0 };
        let matrix = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..p * p).map(|k| weighted(of, &|j| slopes[j][k % p], k / p)).collect()
        };
        let pull = |of: &dyn Fn(usize, usize) -> f64| (0..p).map(|a| weighted(of, &|j| residuals[j], a)).collect();
        Self { noise: matrix(&diagonal), free: matrix(&full), noise_pull: pull(&diagonal), free_pull: pull(&full) }
    }
}

/// What becomes of the parameters, whose posterior has this covariance (p x p); `None` where it is singular.
pub fn moved(covariance: &[f64], p: usize, sensors: &[Information]) -> Option<Vec<Moved>> {
    let posterior = DMatrix::from_row_slice(p, p, covariance);
    let sds: Vec<f64> = (0..p).map(|i| posterior[(i, i)].sqrt()).collect();
    if p == 0 || sds.iter().any(|sd| !(*sd > 0.0 && sd.is_finite())) {
        return None;
    }
    // In standard deviations, so that units do not spoil the arithmetic.
    let scaled = |of: &dyn Fn(&Information) -> &Vec<f64>| {
        let mut sum = DMatrix::zeros(p, p);
        for sensor in sensors {
            sum += DMatrix::from_fn(p, p, |a, b| of(sensor)[a * p + b] * sds[a] * sds[b]);
        }
        sum
    };
    let correlation = DMatrix::from_fn(p, p, |a, b| posterior[(a, b)] / (sds[a] * sds[b]));
    let (noise, free) = (scaled(&|sensor| &sensor.noise), scaled(&|sensor| &sensor.free));
    let rest = correlation.clone().try_inverse()? - &noise;
    // What else is known, the prior above all, is no negative information.
    let parts = SymmetricEigen::new((&rest + rest.transpose()) * 0.5);
    let kept = DMatrix::from_diagonal(&parts.eigenvalues.map(|value| value.max(1e-6)));
    let rest = &parts.eigenvectors * kept * parts.eigenvectors.transpose();
    let free_covariance = (rest + &free).try_inverse()?;
    let pull = DVector::from_fn(p, |a, _| {
        sensors.iter().map(|sensor| (sensor.free_pull[a] - sensor.noise_pull[a]) * sds[a]).sum::<f64>()
    });
    let shift = &free_covariance * pull;
    let of = |a: usize| Moved {
        sd: sds[a],
        free_sd: sds[a] * free_covariance[(a, a)].max(0.0).sqrt(),
        shift: sds[a] * shift[a],
        absorbed: if noise[(a, a)] > 0.0 { (1.0 - free[(a, a)] / noise[(a, a)]).clamp(0.0, 1.0) } else { 0.0 },
    };
    let moved: Vec<Moved> = (0..p).map(of).collect();
    moved.iter().all(|own| own.free_sd.is_finite() && own.shift.is_finite()).then_some(moved)
}
