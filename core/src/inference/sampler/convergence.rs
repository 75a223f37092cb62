//! Whether chains can be trusted, parameter by parameter, and what stands against it.
//!
//! Thresholds of Vehtari, Gelman, Simpson, Carpenter & Buerkner (2021): R-hat below 1.01, effective sample sizes of bulk
//! and tail of 400 or more.

use serde::{Deserialize, Serialize};

use crate::inference::sampler::chains::Chains;
use crate::math::functions::ln;
use crate::random::Distribution;
use crate::statistics::chain_diagnostics as diagnostics;

/// What is asked of chains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceLimits {
    /// Greatest R-hat.
    pub r_hat: f64,
    /// Least effective sample size, of bulk and of tail.
    pub effective: f64,
    /// Greatest share of draws whose trajectory diverged.
    pub divergent_share: f64,
    /// Greatest share of draws whose trajectory reached the greatest depth.
    pub depth_limited_share: f64,
    /// Part of a prior's interval next to a bound that counts as at the bound.
    pub bound_margin: f64,
    /// Greatest share of draws at a bound.
    pub bound_share: f64,
}

impl Default for ConvergenceLimits {
    fn default() -> Self {
        Self {
            r_hat: 1.01,
            effective: 400.0,
            divergent_share: 0.001,
            depth_limited_share: 0.05,
            bound_margin: 0.01,
            bound_share: 0.05,
        }
    }
}

/// Diagnostics and summary of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterDiagnostics {
    /// Name.
    pub name: String,
    /// Mean, SI.
    pub mean: f64,
    /// Standard deviation, SI.
    pub sd: f64,
    /// Monte Carlo standard error of the mean.
    pub mcse_mean: Option<f64>,
    /// Monte Carlo standard error of the standard deviation.
    pub mcse_sd: Option<f64>,
    /// Rank-normalised split R-hat; `None` where it has no value, as for draws that never change.
    pub r_hat: Option<f64>,
    /// Effective sample size of the bulk.
    pub ess_bulk: Option<f64>,
    /// Effective sample size of the tails.
    pub ess_tail: Option<f64>,
    /// Share of draws next to the lower bound; `None` without an interval of finite length.
    pub share_at_lower: Option<f64>,
    /// Share of draws next to the upper bound.
    pub share_at_upper: Option<f64>,
}

/// Something that stands against chains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objection {
    /// Chains disagree or drift.
    RHat {
        /// Place of the parameter.
        parameter: usize,
        /// R-hat; `None` where it has no value.
        value: Option<f64>,
    },
    /// Too few effective draws in the bulk.
    EssBulk {
        /// Place of the parameter.
        parameter: usize,
        /// Effective sample size.
        value: Option<f64>,
    },
    /// Too few effective draws in the tails.
    EssTail {
        /// Place of the parameter.
        parameter: usize,
        /// Effective sample size.
        value: Option<f64>,
    },
    /// Too many trajectories diverged.
    Divergences {
        /// Their number.
        count: u64,
    },
    /// Too many trajectories were cut short.
    DepthLimited {
        /// Their number.
        count: u64,
    },
}

/// A parameter whose posterior leans on a bound of its prior: no fault of the chains, but of the prior or the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeaningOnBound {
    /// Place of the parameter.
    pub parameter: usize,
    /// Whether the upper bound.
    pub upper: bool,
    /// Share of the draws next to it.
    pub share: f64,
}

/// The verdict on chains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Whether nothing stands against the chains.
    pub converged: bool,
    /// What does.
    pub objections: Vec<Objection>,
    /// Parameters that lean on a bound.
    pub leaning: Vec<LeaningOnBound>,
    /// Diagnostics by parameter.
    pub parameters: Vec<ParameterDiagnostics>,
}

/// Judges chains against limits.
pub fn judge(chains: &Chains, priors: &[Distribution], limits: &ConvergenceLimits) -> Convergence {
    let mut objections = Vec::new();
    let mut leaning = Vec::new();
    let mut parameters = Vec::with_capacity(priors.len());
    for (parameter, prior) in priors.iter().enumerate() {
        let draws = chains.parameter(parameter);
        let diagnosis = diagnose(&chains.names[parameter], &draws, prior, limits.bound_margin);
        if diagnosis.r_hat.is_none_or(|value| value >= limits.r_hat) {
            objections.push(Objection::RHat { parameter, value: diagnosis.r_hat });
        }
        if diagnosis.ess_bulk.is_none_or(|value| value < limits.effective) {
            objections.push(Objection::EssBulk { parameter, value: diagnosis.ess_bulk });
        }
        if diagnosis.ess_tail.is_none_or(|value| value < limits.effective) {
            objections.push(Objection::EssTail { parameter, value: diagnosis.ess_tail });
        }
        for (upper, share) in [(false, diagnosis.share_at_lower), (true, diagnosis.share_at_upper)] {
            if let Some(share) = share.filter(|share| *share > limits.bound_share) {
                leaning.push(LeaningOnBound { parameter, upper, share });
            }
        }
        parameters.push(diagnosis);
    }
    let draws = chains.len() as f64;
    let divergences: u64 = chains.chains.iter().map(|chain| chain.moves.divergences).sum();
    if divergences as f64 > limits.divergent_share * draws {
        objections.push(Objection::Divergences { count: divergences });
    }
    let depth_limited: u64 = chains.chains.iter().map(|chain| chain.moves.depth_limited).sum();
    if depth_limited as f64 > limits.depth_limited_share * draws {
        objections.push(Objection::DepthLimited { count: depth_limited });
    }
    Convergence { converged: objections.is_empty(), objections, leaning, parameters }
}

fn diagnose(name: &str, draws: &[Vec<f64>], prior: &Distribution, margin: f64) -> ParameterDiagnostics {
    let count = draws.iter().map(Vec::len).sum::<usize>() as f64;
    let mean = draws.iter().flatten().sum::<f64>() / count;
    let squares: f64 = draws.iter().flatten().map(|x| (x - mean) * (x - mean)).sum();
    let (lower, upper) = prior.support();
    // On the scale on which the prior is even: a loguniform prior reaches over decades.
    let scale = |x: f64| if matches!(prior, Distribution::LogUniform { .. }) { ln(x) } else { x };
    let (lower, upper) = (scale(lower), scale(upper));
    let near = margin * (upper - lower);
    let share = |at: &dyn Fn(f64) -> bool| {
        near.is_finite().then(|| draws.iter().flatten().filter(|x| at(scale(**x))).count() as f64 / count)
    };
    ParameterDiagnostics {
        name: name.to_owned(),
        mean,
        sd: (squares / (count - 1.0)).sqrt(),
        mcse_mean: diagnostics::mcse_mean(draws),
        mcse_sd: diagnostics::mcse_sd(draws).filter(|value| value.is_finite()),
        r_hat: diagnostics::r_hat(draws),
        ess_bulk: diagnostics::ess_bulk(draws),
        ess_tail: diagnostics::ess_tail(draws),
        share_at_lower: share(&|x| x <= lower + near),
        share_at_upper: share(&|x| x >= upper - near),
    }
}
