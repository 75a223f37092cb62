//! A posterior as prior: draws of several parameters together, which stand in for their priors in another job.
//!
//! What samples the prior takes whole draws, so that correlations, bounds and curved shapes stay as they were; what needs a
//! density gets one from [`PosteriorPrior::density`], or is refused where none describes the draws.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use thiserror::Error;

use crate::inference::prior::joint_prior::{JointPrior, JointPriorError};
use crate::random::Distribution;
use crate::statistics::moments::Moments;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Probability beyond three standard deviations of a normal distribution, on one side.
const THREE_SIGMA: f64 = 0.001_349_898_031_630_094_5;

/// Why a calibration's result gives no draws.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}")]
pub struct PosteriorError(String);

/// Draws that stand in for priors.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorPrior {
    /// Where they come from, for people: `tuned` of `pass-1.json`, or a file.
    pub source: String,
    /// Positions of the parameters in the model's list.
    pub parameters: Vec<usize>,
    /// Their names in the source, in the same order.
    pub names: Vec<String>,
    /// SHA-256 of the file of draws; `None` for a calibration's, which the key of that job stands for.
    pub sha256: Option<String>,
    /// Draws (SI), each the values of `parameters`; none before the calibration has its result.
    pub draws: Vec<Vec<f64>>,
    /// Effective number of draws.
    pub effective: f64,
    /// Whether the chains that they come from converged.
    pub converged: bool,
}

/// Draws that stood in for priors, as results tell of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PosteriorPriorSummary {
    /// Where they come from.
    pub source: String,
    /// The parameters.
    pub parameters: Vec<String>,
    /// Number of draws.
    pub draws: u64,
    /// How many independent draws they are worth.
    pub effective: f64,
    /// Whether the chains that they come from converged.
    pub converged: bool,
}

/// The part of a calibration's result that is used.
#[derive(Deserialize)]
struct Calibrated {
    converged: bool,
    order: Vec<String>,
    parameters: BTreeMap<String, Diagnostics>,
    draws: Draws,
}

#[derive(Deserialize)]
struct Diagnostics {
    ess_bulk: Option<f64>,
    ess_tail: Option<f64>,
}

#[derive(Deserialize)]
struct Draws {
    values: Vec<Vec<f64>>,
}

impl PosteriorPrior {
    /// The same with the draws of a calibration's result.
    ///
    /// # Errors
    /// A result without draws of these parameters.
    pub fn filled(&self, result: &Value) -> Result<Self, PosteriorError> {
        let failed = |reason: String| PosteriorError(format!("the posterior of {}: {reason}", self.source));
        let calibrated = Calibrated::deserialize(result).map_err(|error| failed(error.to_string()))?;
        let mut columns = Vec::new();
        let mut effective = calibrated.draws.values.len() as f64;
        for name in &self.names {
            let column = calibrated.order.iter().position(|inferred_name| inferred_name == name);
            columns.push(column.ok_or_else(|| failed(format!("`{name}` was not inferred")))?);
            let effective_sizes = calibrated.parameters.get(name).map(|summary| [summary.ess_bulk, summary.ess_tail]);
            // Where it has no value the draws do not vary: nothing is known of their number.
            effective =
                effective_sizes.into_iter().flatten().fold(effective, |least, ess| least.min(ess.unwrap_or(1.0)));
        }
        let draw =
            |all: &Vec<f64>| columns.iter().map(|&column| all.get(column).copied()).collect::<Option<Vec<f64>>>();
        let draws = calibrated.draws.values.iter().map(draw).collect::<Option<Vec<_>>>();
        let draws = draws.ok_or_else(|| failed("a draw is too short".to_owned()))?;
        if draws.is_empty() || draws.iter().flatten().any(|value| !value.is_finite()) {
            return Err(failed("it has no draws, or one that is not finite".to_owned()));
        }
        Ok(Self { draws, effective, converged: calibrated.converged, ..self.clone() })
    }

    /// What of it decides a result, beside the calibration that it comes from.
    pub fn identity(&self) -> Value {
        json!({ "parameters": self.parameters, "names": self.names, "file": self.sha256 })
    }

    /// Its part in a result.
    pub fn summary(&self) -> PosteriorPriorSummary {
        PosteriorPriorSummary {
            source: self.source.clone(),
            parameters: self.names.clone(),
            draws: self.draws.len() as u64,
            effective: self.effective,
            converged: self.converged,
        }
    }

    /// The same of some of its parameters, by their places.
    pub fn with(&self, places: &[usize]) -> Self {
        Self {
            parameters: places.iter().map(|&place| self.parameters[place]).collect(),
            names: places.iter().map(|&place| self.names[place].clone()).collect(),
            draws: self.draws.iter().map(|draw| places.iter().map(|&place| draw[place]).collect()).collect(),
            ..self.clone()
        }
    }

    /// The same before it is filled.
    pub fn with_no_draws(&self) -> Self {
        Self { draws: Vec::new(), ..self.clone() }
    }

    /// The draws of one parameter, by its place in `parameters`.
    pub fn column(&self, place: usize) -> Vec<f64> {
        self.draws.iter().map(|draw| draw[place]).collect()
    }

    /// Position of the draw that belongs to a share (0 to 1) of the sample space.
    #[inline]
    pub fn position(&self, share: f64) -> usize {
        // Below the number of draws for any share below 1.
        ((share * self.draws.len() as f64) as usize).min(self.draws.len().saturating_sub(1))
    }

    /// A parameter's interval between the quantiles that lie three standard deviations from the mean of a normal
    /// distribution, as a prior: what a stack of worst cases takes the ends of. One value where the draws do not vary.
    pub fn interval(&self, place: usize) -> Distribution {
        let draws = sorted(&self.column(place));
        let (lower, upper) = (quantile_sorted(&draws, THREE_SIGMA), quantile_sorted(&draws, 1.0 - THREE_SIGMA));
        if lower < upper { Distribution::Uniform { lower, upper } } else { Distribution::Fixed(lower) }
    }

    /// Mean, standard deviation and the quantiles of 2.5, 50 and 97.5 % of a parameter, SI.
    pub fn moments(&self, place: usize) -> [f64; 5] {
        let draws = sorted(&self.column(place));
        let moments = Moments::of(&draws);
        let quantile = |share: f64| quantile_sorted(&draws, share);
        [moments.mean(), moments.sd(), quantile(0.025), quantile(0.5), quantile(0.975)]
    }

    /// A density for the parameters that `chosen` (positions in the model's list) has too, in whose order they are the
    /// unknowns; `base` are the priors, by position in the model's list, by which their scores are taken. `None` where
    /// none is chosen.
    ///
    /// # Errors
    /// [`JointPriorError`] where no density describes the draws.
    pub fn density(&self, chosen: &[usize], base: &[Distribution]) -> Result<Option<JointPrior>, JointPriorError> {
        let (mut places, mut columns) = (Vec::new(), Vec::new());
        for (column, parameter) in self.parameters.iter().enumerate() {
            if let Some(place) = chosen.iter().position(|chosen_parameter| chosen_parameter == parameter) {
                places.push(place);
                columns.push(column);
            }
        }
        if places.is_empty() {
            return Ok(None);
        }
        let names: Vec<&str> = columns.iter().map(|&column| self.names[column].as_str()).collect();
        let base: Vec<Distribution> = columns.iter().map(|&column| base[self.parameters[column]]).collect();
        let draws: Vec<Vec<f64>> =
            self.draws.iter().map(|draw| columns.iter().map(|&column| draw[column]).collect()).collect();
        JointPrior::new(&places, &names, &base, &draws, self.effective).map(Some)
    }
}
