//! The most probable parameters from several starts, with their Laplace covariance and evidence, and what is wrong with
//! the fit in data: parameters at a bound, directions that the data do not see, parameters that act only together.
//!
//! The maximum is that of the density over natural coordinates (`natural`: logarithms where the prior is logarithmic).
//! Evidence with active bounds as in [`crate::inference::estimate::laplace`].

use serde::{Deserialize, Serialize};

use crate::inference::estimate::identifiability::{self, Finding};
use crate::inference::estimate::laplace::{self, Laplace};
use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::estimate::optimise::{Bounds, Effort, Minimum, free_variables, hessian, minimise_beside};
use crate::inference::estimate::truncated_moments::{Moments, moments};
use crate::inference::posterior::Work;
use crate::inference::prior::triangular_transport::NormalApproximation;
use crate::inference::sampler::chains::{SampleError, most_frequent};
use crate::inference::target::LeastSquares;
use crate::random::{PointKind, Points, StreamKey};
use crate::watch;

/// Settings of the point estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointSettings {
    /// Starts: the prior's medians, then Sobol points of the prior.
    pub starts: usize,
    /// Most steps from each start.
    pub most_iterations: u64,
    /// Steps that gain less in log posterior density end a descent; 0 for the precision of the arithmetic.
    pub least_gain: f64,
    /// A log likelihood that an estimate of any use exceeds: with costly steps, descents that do not lead there are left before
    /// their end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_log_likelihood: Option<f64>,
    /// Take the Hessian by differences of the gradient instead of the Jacobian's product; done in any case where a noise
    /// parameter is inferred or a prior is triangular.
    pub exact_hessian: bool,
    /// Look for what is wrong with the fit; else there are no findings.
    pub findings: bool,
    /// Take the moments between bounds.
    pub moments: bool,
}

impl Default for PointSettings {
    fn default() -> Self {
        Self {
            starts: 8,
            most_iterations: 200,
            least_gain: 0.0,
            least_log_likelihood: None,
            exact_hessian: false,
            findings: true,
            moments: false,
        }
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
    /// Whitened residuals of the data; they are not stored.
    #[serde(skip)]
    pub residuals: Vec<f64>,
    /// Bounds at which parameters are held.
    pub held: Vec<Option<End>>,
    /// Laplace covariance, SI, to first order in the coordinates; zero for held parameters. Bounds are not considered.
    pub covariance: Vec<f64>,
    /// Laplace log evidence, bounds considered; `None` where no curvature could be had.
    pub log_evidence: Option<f64>,
    /// Means and standard deviations with bounds considered, SI, to first order in the coordinates; where they are asked for and exist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truncated_moments: Option<Moments>,
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
    let count = starts.len() as u64;
    let mut descents = Vec::with_capacity(starts.len());
    let effort = Effort {
        most_iterations: settings.most_iterations,
        least_gain: settings.least_gain,
        // But for the priors' rows, which are few.
        ceiling: settings.least_log_likelihood.map_or(f64::INFINITY, |least| -least),
    };
    let mut best: Option<Minimum> = None;
    for start in starts {
        watch::at(descents.len() as u64, count);
        let from = objective.coordinates(&start);
        let minimum = minimise_beside(&mut objective, &from, &bounds, effort, best.as_ref());
        descents.push(Descent {
            start,
            end: minimum.as_ref().map(|m| objective.parameters(&m.x)),
            log_posterior: minimum.as_ref().map(|m| log_posterior(&objective, m)),
            iterations: minimum.as_ref().map_or(0, |m| m.iterations),
            converged: minimum.as_ref().is_some_and(|m| m.converged),
        });
        if let Some(minimum) = minimum
            && best.as_ref().is_none_or(|lowest| minimum.value < lowest.value)
        {
            best = Some(minimum);
        }
    }
    let Some(best) = best else {
        // A start that no reason speaks against has a sum of squares beyond all numbers.
        let reason = match objective.work.rejections.by_reason.is_empty() {
            true => "the sum of squares is not finite: is the noise far too small?".to_owned(),
            false => most_frequent(&objective.work.rejections),
        };
        return Err(SampleError::NoStart { tries: descents.len() as u64, reason });
    };
    let exact = settings.exact_hessian || best.penalised;
    let free = free_variables(&best.x, &best.gradient, &bounds);
    // Short of a minimum second derivatives may point down; the slopes' part of them does not.
    let is_positive = |curvature: &Vec<f64>| laplace::factor(&best.x, &bounds, curvature, &free).is_some();
    let curvature = exact.then(|| hessian(&mut objective, &best.x, &bounds)).flatten().filter(is_positive);
    let curvature = curvature.unwrap_or_else(|| product(&best.jacobian, best.x.len()));
    let elsewhere = descents.iter().rev().find_map(|descent| descent.end.is_some().then(|| descent.start.clone()));
    let findings = if settings.findings {
        identifiability::findings(target, &mut objective, &best, &bounds, elsewhere.as_deref())
    } else {
        Vec::new()
    };
    let mut estimate = assemble(&objective, &best, &bounds, &curvature, findings, descents);
    if settings.moments {
        estimate.truncated_moments = truncated_moments(&objective, &best, &bounds, &curvature);
    }
    Ok(estimate)
}

/// The moments of the parameters.
fn truncated_moments<T: LeastSquares>(
    objective: &NaturalObjective<'_, T>,
    best: &Minimum,
    bounds: &Bounds,
    curvature: &[f64],
) -> Option<Moments> {
    let free = free_variables(&best.x, &best.gradient, bounds);
    let of_coordinates = moments(&best.x, &best.gradient, bounds, curvature, &free)?;
    let mean = objective.parameters(&of_coordinates.mean);
    let slope = |i: usize| if objective.logarithmic()[i] { mean[i] } else { 1.0 };
    let sd = of_coordinates.sd.iter().enumerate().map(|(i, sd)| sd * slope(i)).collect();
    Some(Moments { mean, sd })
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
    if let Some(laplace) = Laplace::new(&best.x, &best.gradient, bounds, curvature, &free) {
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                let slope = |k: usize| if objective.logarithmic()[k] { parameters[k] } else { 1.0 };
                covariance[i * n + j] = laplace.covariance[a * free.len() + b] * slope(i) * slope(j);
            }
        }
        log_evidence = laplace.log_volume.map(|volume| log_likelihood + log_prior + volume);
    }
    let residuals = best.residuals[..objective.data_rows()].to_vec();
    PointEstimate {
        chi_square: residuals.iter().map(|r| r * r).sum(),
        residuals,
        parameters,
        log_likelihood,
        log_prior,
        held,
        covariance,
        log_evidence,
        truncated_moments: None,
        findings,
        descents,
        work: objective.work.clone(),
    }
}
