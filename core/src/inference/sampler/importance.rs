//! Evidence by importance sampling with a multivariate t density round the mode in unconstrained coordinates.
//!
//! In these coordinates a posterior pressed against a bound has a mode inside and tails that a t density covers. The
//! Pareto shape of the weights tells whether the estimate can be trusted (`psis`).
//!
//! Where draws are costly, they end after a block at which the standard error is small enough, or the shape tells that more
//! of them would not help. The stated error then is that of the draws made; that it chose their number matters little,
//! since it has settled by then.

use serde::{Deserialize, Serialize};

use crate::inference::posterior::{Evaluator, Posterior, Work};
use crate::inference::sampler::chains::{SampleError, start_point};
use crate::inference::sampler::psis;
use crate::inference::sampler::student::StudentProposal;
use crate::inference::target::Target;
use crate::math::cholesky;
use crate::math::functions::{exp, ln};
use crate::math::sum::log_sum_exp;
use crate::random::StreamKey;
use crate::watch;

/// Settings of importance sampling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImportanceSettings {
    /// Draws, at most.
    pub draws: usize,
    /// Standard error of the log evidence that is good enough to end before all draws are made; 0: none is.
    pub wanted_error: f64,
    /// Degrees of freedom of the proposal, 1 or more, a whole number.
    pub degrees: u32,
    /// Factor of the proposal's covariance over that of the mode, above 0.
    pub widening: f64,
}

impl Default for ImportanceSettings {
    fn default() -> Self {
        Self { draws: 4000, wanted_error: 0.0, degrees: 5, widening: 1.2 }
    }
}

/// Draws from one look at the error to the next.
const BLOCK: usize = 500;
/// Shape of the weights' tail from which on their mean need not exist, so that more draws would not help; looked at after
/// this many draws.
const HOPELESS_SHAPE: f64 = 1.0;
const SHAPE_SETTLES: usize = 1000;

/// An importance estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImportanceEstimate {
    /// Logarithm of the evidence.
    pub log_evidence: f64,
    /// Its standard error, to first order from the scatter of the weights.
    pub log_evidence_error: f64,
    /// Effective number of draws.
    pub effective: f64,
    /// Pareto shape of the weights; `None` where too few draws have weight. Above 0.7 the estimate is not to be trusted.
    pub pareto_k: Option<f64>,
    /// Posterior mean of the parameters, SI.
    pub mean: Vec<f64>,
    /// Posterior standard deviation of the parameters, SI.
    pub sd: Vec<f64>,
    /// Evaluations.
    pub work: Work,
}

/// Estimates the evidence from a start (SI; else a draw from the prior) by way of the mode; `replicate` picks the stream.
///
/// # Errors
/// [`SampleError`] for a prior without a map, settings out of range, or no point to start from.
pub fn estimate<T: Target>(
    target: &T,
    settings: &ImportanceSettings,
    key: &StreamKey,
    replicate: u64,
    start: Option<&[f64]>,
) -> Result<ImportanceEstimate, SampleError> {
    let check = SampleError::check;
    check("draws", settings.draws as f64, settings.draws >= 2, "2 or more")?;
    check("degrees", f64::from(settings.degrees), settings.degrees >= 1, "1 or more")?;
    let wanted = settings.wanted_error;
    check("wanted_error", wanted, wanted >= 0.0 && wanted.is_finite(), "0 or more")?;
    check("widening", settings.widening, settings.widening > 0.0 && settings.widening.is_finite(), "above 0")?;
    let posterior = Posterior::new(target)?;
    let mut stream = key.stream(replicate);
    let mut evaluator = posterior.evaluator();
    let inner = start.map(|start| posterior.inner_parameters(start));
    let from = start_point(&posterior, &mut evaluator, &mut stream, inner.as_deref(), true)?;
    let n = posterior.dimension();
    let (mode, mut factor) = find_mode(&mut evaluator, from.coordinates, from.gradient, from.density.total());
    for value in &mut factor {
        *value *= settings.widening.sqrt();
    }
    let mut proposal = StudentProposal::new(mode, factor, settings.degrees);
    let mut log_ratios = Vec::with_capacity(settings.draws);
    let mut parameters = Vec::with_capacity(settings.draws * n);
    let mut coordinates = vec![0.0; n];
    for draw in 0..settings.draws {
        watch::at(draw as u64, settings.draws as u64);
        let log_proposal = proposal.draw(&mut stream, &mut coordinates);
        let density = evaluator.density(&coordinates);
        log_ratios.push(density.map_or(f64::NEG_INFINITY, |density| density.total() - log_proposal));
        parameters.extend_from_slice(evaluator.parameters());
        if wanted > 0.0 && log_ratios.len() % BLOCK == 0 && is_enough(&log_ratios, wanted) {
            break;
        }
    }
    Ok(summarise(&log_ratios, &parameters, n, evaluator.work.clone()))
}

/// Whether draws need not go on: their error is the wanted one with weights that can be trusted, or they never will be.
fn is_enough(log_ratios: &[f64], wanted: f64) -> bool {
    let shape = psis::smooth(log_ratios, 1.0).pareto_k;
    let trusted = shape <= psis::greatest_good_shape(log_ratios.len());
    let hopeless = shape > HOPELESS_SHAPE && log_ratios.len() >= SHAPE_SETTLES;
    hopeless || trusted && error(log_ratios.len() as f64, sum_of_squares(&weights(log_ratios))) <= wanted
}

/// Shares of the draws.
fn weights(log_ratios: &[f64]) -> Vec<f64> {
    let total = log_sum_exp(log_ratios);
    log_ratios.iter().map(|l| exp(l - total)).collect()
}

fn sum_of_squares(weights: &[f64]) -> f64 {
    weights.iter().map(|w| w * w).sum()
}

/// Standard error of the log evidence, to first order, from the squared shares of so many draws.
fn error(count: f64, squares: f64) -> f64 {
    ((squares - 1.0 / count).max(0.0) * count / (count - 1.0)).sqrt()
}

fn summarise(log_ratios: &[f64], parameters: &[f64], n: usize, work: Work) -> ImportanceEstimate {
    let count = log_ratios.len() as f64;
    let weights = weights(log_ratios);
    let squares = sum_of_squares(&weights);
    // A draw without weight has parameters that need not be finite.
    let moment = |i: usize, centre: f64, power: bool| {
        weights
            .iter()
            .zip(parameters.chunks_exact(n))
            .filter(|(w, _)| **w > 0.0)
            .map(|(w, draw)| {
                let deviation = draw[i] - centre;
                w * if power { deviation * deviation } else { deviation }
            })
            .sum::<f64>()
    };
    let mean: Vec<f64> = (0..n).map(|i| moment(i, 0.0, false)).collect();
    let sd = (0..n).map(|i| moment(i, mean[i], true).sqrt()).collect();
    let pareto_k = psis::smooth(log_ratios, 1.0).pareto_k;
    ImportanceEstimate {
        log_evidence: log_sum_exp(log_ratios) - ln(count),
        log_evidence_error: error(count, squares),
        effective: 1.0 / squares,
        pareto_k: pareto_k.is_finite().then_some(pareto_k),
        mean,
        sd,
        work,
    }
}

/// The mode and the factor of the inverse Hessian there: Newton steps of limited length, the Hessian by differences of
/// the gradient, damped where it is not positive definite.
fn find_mode<T: Target>(
    evaluator: &mut Evaluator<'_, T>,
    mut at: Vec<f64>,
    mut gradient: Vec<f64>,
    mut value: f64,
) -> (Vec<f64>, Vec<f64>) {
    const LONGEST: f64 = 3.0;
    let n = at.len();
    let mut trial_gradient = vec![0.0; n];
    for _ in 0..100 {
        let factor = damped_factor(evaluator, &at, &gradient);
        let mut step = gradient.clone();
        cholesky::solve(&factor, &mut step);
        let length = step.iter().map(|s| s * s).sum::<f64>().sqrt();
        let mut share = if length > LONGEST { LONGEST / length } else { 1.0 };
        let mut gained = 0.0;
        for _ in 0..20 {
            let trial: Vec<f64> = at.iter().zip(&step).map(|(z, s)| z + share * s).collect();
            if let Some(density) = evaluator.density_gradient(&trial, &mut trial_gradient)
                && density.total() > value
            {
                gained = density.total() - value;
                value = density.total();
                at = trial;
                std::mem::swap(&mut gradient, &mut trial_gradient);
                break;
            }
            share *= 0.4;
        }
        if gained < 1e-8 {
            break;
        }
    }
    let precision = damped_factor(evaluator, &at, &gradient);
    let mut covariance = cholesky::inverse(&precision, n);
    if cholesky::factor(&mut covariance, n).is_err() {
        // The inverse of a factored matrix fails only by rounding; the diagonal then serves.
        covariance = vec![0.0; n * n];
        for i in 0..n {
            covariance[i * n + i] = 1.0 / precision[i * n + i];
        }
    }
    (at, covariance)
}

/// Factor of the negative Hessian of the log density, plus as much of the unit matrix as makes it positive definite.
fn damped_factor<T: Target>(evaluator: &mut Evaluator<'_, T>, at: &[f64], gradient: &[f64]) -> Vec<f64> {
    const STEP: f64 = 1e-4;
    let n = at.len();
    let mut hessian = vec![0.0; n * n];
    let mut point = at.to_vec();
    let (mut above, mut below) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        point[j] = at[j] + STEP;
        let high = evaluator.density_gradient(&point, &mut above).is_some();
        point[j] = at[j] - STEP;
        let low = evaluator.density_gradient(&point, &mut below).is_some();
        point[j] = at[j];
        for i in 0..n {
            let (high, low) = (if high { above[i] } else { gradient[i] }, if low { below[i] } else { gradient[i] });
            hessian[i * n + j] = (low - high) / (2.0 * STEP);
        }
    }
    let mut damping = 0.0;
    loop {
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                factor[i * n + j] = 0.5 * (hessian[i * n + j] + hessian[j * n + i]);
            }
            factor[i * n + i] += damping;
        }
        if cholesky::factor(&mut factor, n).is_ok() {
            return factor;
        }
        damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
        if damping > 1e20 {
            // Nothing finite is left of the Hessian: the unit matrix.
            factor.fill(0.0);
            for i in 0..n {
                factor[i * n + i] = 1.0;
            }
            return factor;
        }
    }
}
