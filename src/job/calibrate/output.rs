//! Settings and result of a calibration.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::sampler::Sampler;

use crate::inference::prior::joint_prior::Fit;
use crate::job::key_number::KeyNumber;
use crate::random::Distribution;
use crate::study::posterior_prior::PosteriorPriorSummary;

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Positions of the measurements in the pass's list.
    pub data: Vec<usize>,
    /// Positions of the chosen parameters in the model's list.
    pub parameters: Vec<usize>,
    /// How the posterior is sampled.
    pub sampler: Sampler,
    /// Number of chains.
    pub chains: u64,
    /// Steps of a chain that adapt and are dropped.
    pub warmup: u64,
    /// Draws of a chain that are kept.
    pub draws: u64,
    /// Mean acceptance that trajectories aim at; the sampler's own where it is `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceptance: Option<f64>,
}

/// A posterior that is the prior of a parameter, in the parameter's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PosteriorPriorOf {
    /// Where it comes from.
    pub source: String,
    /// Mean of its draws.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Quantile of 2.5 %.
    pub q025: f64,
    /// Median.
    pub q50: f64,
    /// Quantile of 97.5 %.
    pub q975: f64,
}

/// A parameter's posterior. Numbers are in `unit`, the prior is in SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ParameterSummary {
    /// Unit.
    pub unit: String,
    /// Prior, SI; where draws stand in for it, the original one, by which their normal scores are taken.
    #[schemars(with = "serde_json::Value")]
    pub prior: Distribution,
    /// The posterior that is the prior, where one is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior_prior: Option<PosteriorPriorOf>,
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
    /// Quantile of 2.5 %.
    pub q025: f64,
    /// Median.
    pub q50: f64,
    /// Quantile of 97.5 %.
    pub q975: f64,
    /// Rank-normalised split R-hat; `null` where it has no value.
    pub rhat: Option<f64>,
    /// Effective sample size of the bulk.
    pub ess_bulk: Option<f64>,
    /// Effective sample size of the tails.
    pub ess_tail: Option<f64>,
    /// Monte Carlo standard error of the mean.
    pub mcse_mean: Option<f64>,
    /// Share of the draws within 1 % of the prior's interval (of its logarithm for a loguniform prior) from either bound; 0
    /// without an interval.
    pub at_bound: f64,
    /// The most probable value.
    pub map: f64,
    /// Its Laplace standard deviation; 0 where it is held at a bound.
    pub laplace_sd: f64,
}

impl ParameterSummary {
    /// About how large it is, in its unit.
    pub fn size(&self) -> f64 {
        self.mean.abs().max(self.sd)
    }
}

/// Logarithm of the evidence (natural, normalising constants included).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Evidence {
    /// Value.
    pub value: Option<f64>,
    /// Standard error.
    pub sd: Option<f64>,
    /// How it was had: `smc`, `importance sampling`, `laplace`.
    pub method: String,
    /// Pareto shape of the importance weights; above 0.7 the value is not to be trusted.
    pub pareto_k: Option<f64>,
    /// Laplace's value, for comparison.
    pub laplace: Option<f64>,
}

/// Pareto shape of importance weights above which what they give is not to be trusted (Vehtari, Simpson, Gelman, Yao & Gabry
/// 2024).
const TRUSTED: f64 = 0.7;

impl Evidence {
    /// Whether the value and its error are to be trusted: those of importance weights where few of them do not decide all.
    pub fn is_trusted(&self) -> bool {
        self.pareto_k.is_none_or(|k| k <= TRUSTED)
    }
}

/// The most probable point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MostProbable {
    /// Log likelihood.
    pub log_likelihood: f64,
    /// Log density of the prior.
    pub log_prior: f64,
    /// Sum of squares of the whitened residuals.
    pub chi_square: f64,
    /// Number of starts, and how many of them ended there (within 0.1 of the log posterior).
    pub starts: [u64; 2],
}

/// Draws kept of all chains: evenly spaced, by weight where islands have weights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct KeptDraws {
    /// Chain and place in the chain of each draw.
    pub index: Vec<[u64; 2]>,
    /// Values, SI, in the order of `order`.
    pub values: Vec<Vec<f64>>,
    /// Log likelihoods.
    pub log_likelihoods: Vec<f64>,
}

/// What is predicted for a reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PredictiveRow {
    /// Phase of a steady measurement.
    pub phase: Option<String>,
    /// Instant of a transient, s.
    pub time_s: Option<f64>,
    /// Reading, SI; `null` if missing.
    pub measured: Option<f64>,
    /// Posterior mean of the model's reading, SI.
    pub mean: f64,
    /// 95 % band of the model's reading.
    pub band: [f64; 2],
    /// 95 % band of a reading with its noise.
    pub band_with_noise: [f64; 2],
    /// 95 % band of a reading with its noise under the prior.
    pub prior_band: Option<[f64; 2]>,
    /// Kept from the fit.
    pub held_out: bool,
}

/// Share of readings inside a band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Coverage {
    /// Readings.
    pub count: u64,
    /// How many lie inside the 95 % band with noise.
    pub inside: u64,
    /// How many lie inside the prior's 95 % band with noise.
    pub inside_prior: u64,
}

/// Predictive check of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SensorPredictive {
    /// Measurement.
    pub measurement: String,
    /// Sensor.
    pub sensor: String,
    /// SI unit.
    pub unit: String,
    /// Rows that are not ignored.
    pub rows: Vec<PredictiveRow>,
    /// Of the readings for fitting.
    pub train: Coverage,
    /// Of the readings held out.
    pub held_out: Coverage,
    /// Histogram of the probability integral transform in ten equal bins, of the readings for fitting.
    pub pit: Vec<u64>,
}

/// Leave-one-out cross-validation by Pareto-smoothed importance sampling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct CrossValidation {
    /// Expected log density of a reading left out (given those before it where noise is correlated), summed.
    pub expected_log_density: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Effective number of parameters.
    pub effective_parameters: f64,
    /// Readings whose weights are not to be trusted.
    pub unreliable: u64,
}

/// How well a steady phase was predicted by what the others said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PhaseScore {
    /// Measurement.
    pub measurement: String,
    /// Phase.
    pub phase: String,
    /// Readings scored together.
    pub readings: u64,
    /// Log of their joint predictive density, SI: of a phase held out given all that was fitted, of one that was
    /// fitted given the others (Pareto-smoothed importance sampling).
    pub log_density: f64,
    /// Held out of the fit.
    pub held_out: bool,
    /// Whether the importance weights can be trusted; always for a phase held out.
    pub reliable: bool,
}

/// Predictive density of the phases held out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct HeldOutScore {
    /// Sum over the phases.
    pub log_density: f64,
    /// Its standard error, from the scatter over the phases; `null` for one phase.
    pub standard_error: Option<f64>,
    /// Phases.
    pub phases: u64,
    /// Readings.
    pub readings: u64,
}

/// Rows of the data behind a posterior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct UsedData {
    /// Measurement.
    pub measurement: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Readings fitted.
    pub readings: u64,
    /// Rows fitted, each with the SHA-256 of its readings.
    #[serde(default)]
    pub rows: Vec<(String, String)>,
}

/// What was spent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Spent {
    /// Likelihoods without gradient.
    pub likelihoods: u64,
    /// Likelihoods with gradient.
    pub gradients: u64,
    /// Evaluations that failed.
    pub rejected: u64,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Whether nothing stands against the chains.
    pub converged: bool,
    /// What stands against them, in words.
    pub objections: Vec<String>,
    /// Sampler.
    pub sampler: String,
    /// Number of chains, draws of each.
    pub chains: [u64; 2],
    /// Names of all unknowns in order: the model's parameters, then what was inferred of the data.
    pub order: Vec<String>,
    /// How many of them are parameters of the model.
    pub model_parameters: u64,
    /// Posteriors by name.
    pub parameters: BTreeMap<String, ParameterSummary>,
    /// Evidence.
    pub log_evidence: Evidence,
    /// Numbers of the posterior with their Monte Carlo errors, from all draws.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub key_numbers: Vec<KeyNumber>,
    /// Posterior correlations, in the order of `order`.
    pub correlations: Vec<Vec<f64>>,
    /// The most probable point.
    pub most_probable: MostProbable,
    /// The tuned state, SI: the most probable value of every unknown, then the value at which each other parameter of the
    /// model was held. It is a point at which the model was run, also
    /// where the posterior is curved or has several modes, which the mean need not be.
    pub tuned: Vec<(String, f64)>,
    /// What the reader must know about parameters: at a bound, unseen, acting only together.
    pub findings: Vec<String>,
    /// Further warnings.
    pub warnings: Vec<String>,
    /// Share of trajectories' moves accepted, by chain.
    pub acceptance: Vec<f64>,
    /// Draws kept.
    pub draws: KeptDraws,
    /// Draws used for the predictive checks.
    pub predictive_draws: u64,
    /// Predictive checks.
    pub predictive: Vec<SensorPredictive>,
    /// Posterior probability that the noise alone gives a larger sum of squares of the whitened residuals.
    pub p_value: Option<f64>,
    /// Leave-one-out cross-validation.
    pub leave_one_out: Option<CrossValidation>,
    /// The same with whole steady phases left out; nothing without steady phases.
    #[serde(default)]
    pub leave_one_phase_out: Option<CrossValidation>,
    /// Every steady phase's score.
    #[serde(default)]
    pub phases: Vec<PhaseScore>,
    /// Score of the steady phases held out; nothing without such.
    #[serde(default)]
    pub held_out: Option<HeldOutScore>,
    /// Data behind the posterior.
    pub data: Vec<UsedData>,
    /// Posteriors that stand in for priors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior_priors: Vec<PosteriorPriorSummary>,
    /// How well a density describes the draws of each that has parameters here.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior_prior_fits: Vec<Fit>,
    /// Work.
    pub spent: Spent,
}

impl Output {
    /// Sum of squares of the whitened residuals at the most probable point over the degrees of freedom: readings fitted
    /// less unknowns. `None` where there are none left.
    pub fn reduced_chi_square(&self) -> Option<f64> {
        let readings: u64 = self.data.iter().map(|data| data.readings).sum();
        let freedom = readings.checked_sub(self.order.len() as u64).filter(|freedom| *freedom > 0)?;
        Some(self.most_probable.chi_square / freedom as f64)
    }
}
