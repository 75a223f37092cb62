//! The normal approximation of a density between bounds: its covariance and the volume below it.
//!
//! The free part has that of its Hessian and the probability of its box, each part pinned at a bound the integral of
//! `e^(-g t - s t^2 / 2)` from there, `g` the gradient and `s` the curvature left when the free part follows.

use nalgebra::{DMatrix, DVector};

use crate::inference::estimate::box_probability::log_box_probability;
use crate::inference::estimate::optimise::Bounds;
use crate::math::cholesky;
use crate::math::functions::{exp, ln};
use crate::math::quadrature::gauss_legendre;

/// The normal approximation at a point with some variables held at bounds.
pub struct Laplace {
    /// Covariance of the free variables, row by row.
    pub covariance: Vec<f64>,
    /// Logarithm of the integral of the density relative to its maximum.
    pub log_volume: Option<f64>,
}

impl Laplace {
    /// Of a density whose negative logarithm has this gradient and curvature (n x n) at a point; the variables that are
    /// not free stand at a bound. `None` where the curvature of the free variables is negative or undefined.
    pub fn new(at: &[f64], gradient: &[f64], bounds: &Bounds, curvature: &[f64], free: &[usize]) -> Option<Self> {
        let n = at.len();
        let k = free.len();
        let factor = factor(at, bounds, curvature, free)?;
        let covariance = cholesky::inverse(&factor, k);
        let room = |ends: &[f64]| -> Vec<f64> { free.iter().map(|&i| ends[i] - at[i]).collect() };
        let inside = log_box_probability(&covariance, &room(&bounds.lower), &room(&bounds.upper));
        let log_tau = ln(core::f64::consts::TAU);
        let mut volume = 0.5 * (k as f64 * log_tau - cholesky::log_determinant(&factor, k));
        for i in (0..n).filter(|i| !free.contains(i)) {
            // Curvature along the held variable while the free ones follow (Schur complement); 0 where it is negative.
            let mut along: Vec<f64> = free.iter().map(|&j| curvature[j * n + i]).collect();
            cholesky::solve_lower(&factor, &mut along);
            let left = (curvature[i * n + i] - along.iter().map(|v| v * v).sum::<f64>()).max(0.0);
            volume += ln(pinned_integral(gradient[i].abs(), left, bounds.upper[i] - bounds.lower[i]));
        }
        Some(Self { covariance, log_volume: inside.map(|inside| volume + inside) })
    }
}

/// Cholesky factor of the curvature of the free variables, `None` where it is negative or undefined.
pub(super) fn factor(at: &[f64], bounds: &Bounds, curvature: &[f64], free: &[usize]) -> Option<Vec<f64>> {
    let n = at.len();
    let mut free_curvature: Vec<f64> =
        free.iter().flat_map(|&i| free.iter().map(move |&j| curvature[i * n + j])).collect();
    floor_eigenvalues(&mut free_curvature, at, bounds, free);
    cholesky::factor(&mut free_curvature, free.len()).ok()?;
    Some(free_curvature)
}

/// Raises the curvature of directions that data and prior leave open to one that cannot be told from none across the
/// box, so that the box alone limits them. Directions that no bound limits stay as they are.
fn floor_eigenvalues(curvature: &mut [f64], at: &[f64], bounds: &Bounds, free: &[usize]) {
    const LEAST: f64 = 1e-4;
    let k = free.len();
    if k == 0 {
        return;
    }
    let widths: Vec<f64> = free.iter().map(|&i| bounds.upper[i] - bounds.lower[i]).collect();
    let scales: Vec<f64> = (0..k)
        .map(|a| {
            let diagonal = curvature[a * k + a];
            let spread = if diagonal > 0.0 { 1.0 / diagonal.sqrt() } else { f64::INFINITY };
            let scale = spread.min(widths[a]);
            if scale.is_finite() { scale } else { at[free[a]].abs().max(f64::MIN_POSITIVE) }
        })
        .collect();
    let scaled = DMatrix::from_fn(k, k, |a, b| curvature[a * k + b] * scales[a] * scales[b]);
    if scaled.iter().any(|v| !v.is_finite()) {
        return;
    }
    let eigen = scaled.symmetric_eigen();
    let floored = DVector::from_fn(k, |e, _| {
        let reach =
            (0..k).map(|a| widths[a] / (scales[a] * eigen.eigenvectors[(a, e)].abs())).fold(f64::INFINITY, f64::min);
        eigen.eigenvalues[e].max(LEAST / (reach * reach))
    });
    if floored == eigen.eigenvalues {
        return;
    }
    for a in 0..k {
        for b in 0..k {
            let sum: f64 = (0..k).map(|e| eigen.eigenvectors[(a, e)] * floored[e] * eigen.eigenvectors[(b, e)]).sum();
            curvature[a * k + b] = sum / (scales[a] * scales[b]);
        }
    }
}

/// Integral of `e^(-g t - s t^2 / 2)` over t from 0 to a width that may be infinite; g above or at 0, s at least 0.
pub fn pinned_integral(gradient: f64, curvature: f64, width: f64) -> f64 {
    // Beyond forty decay lengths nothing is left.
    let reach = width.min(40.0 / gradient.max(f64::MIN_POSITIVE)).min(9.0 / curvature.max(f64::MIN_POSITIVE).sqrt());
    const PANELS: usize = 16;
    let rule = gauss_legendre(10);
    let step = reach / PANELS as f64;
    (0..PANELS)
        .map(|panel| {
            let from = panel as f64 * step;
            rule.integrate(from, from + step, |t| exp(-t * (gradient + 0.5 * curvature * t)))
        })
        .sum()
}
