//! The most probable parameters from several starts, with their Laplace covariance and evidence, and what is wrong with
//! the fit in data: parameters at a bound, directions that the data do not see, parameters that act only together.
//!
//! The maximum is that of the density over natural coordinates (`natural`: logarithms where the prior is logarithmic).
//! Evidence with active bounds: the free part by its Hessian and the probability of its box, each pinned part by the
//! integral of `e^(-g t - s t^2 / 2)` from its bound, `g` the gradient and `s` the curvature left when the free part
//! follows.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::box_probability::log_box_probability;
use super::chains::{SampleError, most_frequent};
use super::cholesky;
use super::identifiability::{self, Finding};
use super::natural::NaturalObjective;
use super::optimise::{Bounds, Minimum, free_variables, hessian, minimise};
use super::posterior::Work;
use super::shear::NormalApproximation;
use super::target::LeastSquares;
use crate::math::functions::{exp, ln};
use crate::math::quadrature::gauss_legendre;
use crate::random::{PointKind, Points, StreamKey};

/// Settings of the point estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointSettings {
    /// Starts: the prior's medians, then Sobol points of the prior.
    pub starts: usize,
    /// Most steps from each start.
    pub most_iterations: u64,
    /// Take the Hessian by differences of the gradient instead of the Jacobian's product; done in any case where a noise
    /// parameter is inferred or a prior is triangular.
    pub exact_hessian: bool,
    /// Look for what is wrong with the fit; else there are no findings.
    pub findings: bool,
}

impl Default for PointSettings {
    fn default() -> Self {
        Self { starts: 8, most_iterations: 200, exact_hessian: false, findings: true }
    }
}

/// An end of a parameter's support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// Where one start led.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descent {
    /// Where it began, SI.
    pub start: Vec<f64>,
    /// Where it ended, SI; `None` where the start could not be evaluated.
    pub end: Option<Vec<f64>>,
    /// Log posterior over natural coordinates there, not normalised.
    pub log_posterior: Option<f64>,
    /// Steps taken.
    pub iterations: u64,
    /// Whether the steps became negligible.
    pub converged: bool,
}

/// The most probable parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointEstimate {
    /// Parameters, SI.
    pub parameters: Vec<f64>,
    /// Log likelihood.
    pub log_likelihood: f64,
    /// Log density of the prior over natural coordinates.
    pub log_prior: f64,
    /// Sum of squares of the whitened residuals of the data.
    pub chi_square: f64,
    /// Bounds at which parameters are held.
    pub held: Vec<Option<End>>,
    /// Laplace covariance, SI, to first order in the coordinates; zero for held parameters. Bounds are not considered.
    pub covariance: Vec<f64>,
    /// Laplace log evidence, bounds considered; `None` where no curvature could be had.
    pub log_evidence: Option<f64>,
    /// What is wrong with the fit.
    pub findings: Vec<Finding>,
    /// The starts.
    pub descents: Vec<Descent>,
    /// Evaluations.
    pub work: Work,
}

impl PointEstimate {
    /// Laplace standard deviation of each parameter, SI; 0 for held parameters.
    pub fn sd(&self) -> Vec<f64> {
        let n = self.parameters.len();
        (0..n).map(|i| self.covariance[i * n + i].max(0.0).sqrt()).collect()
    }

    /// Laplace's normal distribution; it says nothing of held parameters.
    pub fn normal_approximation(&self) -> NormalApproximation {
        NormalApproximation { mode: self.parameters.clone(), covariance: self.covariance.clone() }
    }
}

/// Estimates from all starts, in their order; `given` (SI) come before the prior's.
///
/// # Errors
/// [`SampleError`] for a prior without spread, or when no start can be evaluated.
pub fn estimate<T: LeastSquares>(
    target: &T,
    settings: &PointSettings,
    key: &StreamKey,
    given: &[Vec<f64>],
) -> Result<PointEstimate, SampleError> {
    let mut objective = NaturalObjective::new(target)?;
    let bounds = objective.bounds();
    let starts = starts(target, settings, key, given);
    let mut descents = Vec::with_capacity(starts.len());
    let mut best: Option<Minimum> = None;
    for start in starts {
        let from = objective.coordinates(&start);
        let minimum = minimise(&mut objective, &from, &bounds, settings.most_iterations);
        descents.push(Descent {
            start,
            end: minimum.as_ref().map(|m| objective.parameters(&m.x)),
            log_posterior: minimum.as_ref().map(|m| log_posterior(&objective, m)),
            iterations: minimum.as_ref().map_or(0, |m| m.iterations),
            converged: minimum.as_ref().is_some_and(|m| m.converged),
        });
        if let Some(minimum) = minimum
            && best.as_ref().is_none_or(|known| minimum.value < known.value)
        {
            best = Some(minimum);
        }
    }
    let Some(best) = best else {
        let reason = most_frequent(&objective.work.rejections);
        return Err(SampleError::NoStart { tries: descents.len() as u64, reason });
    };
    let exact = settings.exact_hessian || best.penalised;
    let curvature = exact.then(|| hessian(&mut objective, &best.x, &bounds)).flatten();
    let curvature = curvature.unwrap_or_else(|| product(&best.jacobian, best.x.len()));
    let elsewhere = descents.iter().rev().find_map(|descent| descent.end.is_some().then(|| descent.start.clone()));
    let findings = if settings.findings {
        identifiability::findings(target, &mut objective, &best, &bounds, elsewhere.as_deref())
    } else {
        Vec::new()
    };
    Ok(assemble(&objective, &best, &bounds, &curvature, findings, descents))
}

/// Starts: those given, the prior's medians, Sobol points of the prior (Monte Carlo in too many dimensions).
fn starts<T: LeastSquares>(target: &T, settings: &PointSettings, key: &StreamKey, given: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let priors = target.priors();
    let mut starts = given.to_vec();
    if settings.starts > 0 {
        starts.push(priors.iter().map(|prior| prior.quantile(0.5)).collect());
    }
    let count = settings.starts.saturating_sub(1);
    let points = Points::new(PointKind::Sobol, *key, count, priors.len())
        .or_else(|_| Points::new(PointKind::MonteCarlo, *key, count, priors.len()));
    if let Ok(points) = points {
        let mut row = vec![0.0; priors.len()];
        for index in 0..count {
            points.fill_row(index, &mut row);
            starts.push(priors.iter().zip(&row).map(|(prior, u)| prior.quantile(*u)).collect());
        }
    }
    starts
}

fn log_likelihood<T: LeastSquares>(objective: &NaturalObjective<'_, T>, minimum: &Minimum) -> f64 {
    // The objective holds the priors' rows and the triangular priors' logs beside the likelihood.
    let rows: f64 = minimum.residuals[objective.data_rows()..].iter().map(|r| 0.5 * r * r).sum();
    rows + objective.triangular_log_density(&minimum.x) - minimum.value
}

fn log_posterior<T: LeastSquares>(objective: &NaturalObjective<'_, T>, minimum: &Minimum) -> f64 {
    log_likelihood(objective, minimum) + objective.log_prior(&minimum.x)
}

/// `J' J`.
pub(super) fn product(jacobian: &[f64], n: usize) -> Vec<f64> {
    let mut product = vec![0.0; n * n];
    for row in jacobian.chunks_exact(n) {
        for i in 0..n {
            for j in 0..n {
                product[i * n + j] += row[i] * row[j];
            }
        }
    }
    product
}

fn assemble<T: LeastSquares>(
    objective: &NaturalObjective<'_, T>,
    best: &Minimum,
    bounds: &Bounds,
    curvature: &[f64],
    findings: Vec<Finding>,
    descents: Vec<Descent>,
) -> PointEstimate {
    let n = best.x.len();
    let free = free_variables(&best.x, &best.gradient, bounds);
    let parameters = objective.parameters(&best.x);
    let held = (0..n)
        .map(|i| {
            let end = if best.x[i] <= bounds.lower[i] { End::Lower } else { End::Upper };
            (!free.contains(&i)).then_some(end)
        })
        .collect();
    let log_likelihood = log_likelihood(objective, best);
    let log_prior = objective.log_prior(&best.x);
    let mut covariance = vec![0.0; n * n];
    let mut log_evidence = None;
    if let Some(laplace) = Laplace::new(best, bounds, curvature, &free) {
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                let slope = |k: usize| if objective.logarithmic()[k] { parameters[k] } else { 1.0 };
                covariance[i * n + j] = laplace.covariance[a * free.len() + b] * slope(i) * slope(j);
            }
        }
        log_evidence = laplace.log_volume.map(|volume| log_likelihood + log_prior + volume);
    }
    PointEstimate {
        chi_square: best.residuals[..objective.data_rows()].iter().map(|r| r * r).sum(),
        parameters,
        log_likelihood,
        log_prior,
        held,
        covariance,
        log_evidence,
        findings,
        descents,
        work: objective.work.clone(),
    }
}

/// The normal approximation at a point with some variables held at bounds.
struct Laplace {
    /// Covariance of the free variables.
    covariance: Vec<f64>,
    /// Logarithm of the integral of the density relative to its maximum.
    log_volume: Option<f64>,
}

impl Laplace {
    /// `None` where the curvature of the free variables is negative or undefined.
    fn new(best: &Minimum, bounds: &Bounds, curvature: &[f64], free: &[usize]) -> Option<Self> {
        let n = best.x.len();
        let k = free.len();
        let mut own: Vec<f64> = free.iter().flat_map(|&i| free.iter().map(move |&j| curvature[i * n + j])).collect();
        floor_eigenvalues(&mut own, best, bounds, free);
        let mut factor = own;
        cholesky::factor(&mut factor, k).ok()?;
        let covariance = cholesky::inverse(&factor, k);
        let room = |ends: &[f64]| -> Vec<f64> { free.iter().map(|&i| ends[i] - best.x[i]).collect() };
        let inside = log_box_probability(&covariance, &room(&bounds.lower), &room(&bounds.upper));
        let log_tau = ln(core::f64::consts::TAU);
        let mut volume = 0.5 * (k as f64 * log_tau - cholesky::log_determinant(&factor, k));
        for i in (0..n).filter(|i| !free.contains(i)) {
            // Curvature along the held variable while the free ones follow (Schur complement); 0 where it is negative.
            let mut along: Vec<f64> = free.iter().map(|&j| curvature[j * n + i]).collect();
            cholesky::solve_lower(&factor, &mut along);
            let left = (curvature[i * n + i] - along.iter().map(|v| v * v).sum::<f64>()).max(0.0);
            volume += ln(pinned_integral(best.gradient[i].abs(), left, bounds.upper[i] - bounds.lower[i]));
        }
        Some(Self { covariance, log_volume: inside.map(|inside| volume + inside) })
    }
}

/// Raises the curvature of directions that data and prior leave open to one that cannot be told from none across the
/// box, so that the box alone limits them. Directions that no bound limits stay as they are.
fn floor_eigenvalues(curvature: &mut [f64], best: &Minimum, bounds: &Bounds, free: &[usize]) {
    const LEAST: f64 = 1e-4;
    let k = free.len();
    if k == 0 {
        return;
    }
    let widths: Vec<f64> = free.iter().map(|&i| bounds.upper[i] - bounds.lower[i]).collect();
    let scales: Vec<f64> = (0..k)
        .map(|a| {
            let own = curvature[a * k + a];
            let spread = if own > 0.0 { 1.0 / own.sqrt() } else { f64::INFINITY };
            let scale = spread.min(widths[a]);
            if scale.is_finite() { scale } else { best.x[free[a]].abs().max(f64::MIN_POSITIVE) }
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
fn pinned_integral(gradient: f64, curvature: f64, width: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_from_a_bound_has_its_limits() {
        // Steep: 1/g. Flat: the width. Curved: half a normal integral.
        assert!((pinned_integral(50.0, 0.0, f64::INFINITY) - 0.02).abs() < 1e-12);
        assert!((pinned_integral(2.0, 0.0, 1.0) - 0.5 * (1.0 - libm::exp(-2.0))).abs() < 1e-12);
        assert!((pinned_integral(0.0, 0.0, 3.0) - 3.0).abs() < 1e-12);
        let half = 0.5 * core::f64::consts::TAU.sqrt() / 2.0;
        assert!((pinned_integral(0.0, 4.0, f64::INFINITY) - half).abs() < 1e-12);
    }
}
