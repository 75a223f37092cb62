//! Settings and result of a propagation.

use std::sync::Arc;

use crate::study::variable::Sweep;
use serde::{Deserialize, Serialize};

use crate::statistics::sobol_indices::Estimate;
use crate::study::posterior_prior::PosteriorPriorSummary;
use crate::study::requirement::{Environment, Requirement};

/// How the priors are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// Independent draws.
    MonteCarlo,
    /// One draw in each of N equal slices of every parameter.
    LatinHypercube,
    /// Scrambled Sobol points.
    #[default]
    Sobol,
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Indices of the quantities in the model's list.
    pub quantities: Vec<usize>,
    /// Number of samples.
    pub samples: u64,
    /// How they are drawn.
    pub sampling: Sampling,
    /// Environments; one named `nominal` with the inputs' nominal values where the study names none.
    pub environments: Vec<Environment>,
    /// Design variable, if any is swept.
    pub sweep: Option<Sweep>,
    /// Pairs (positions in `quantities`) whose joint distribution is wanted.
    pub joint: Vec<[usize; 2]>,
    /// Requirements, whose quantities are among `quantities`.
    pub requirements: Vec<Requirement>,
    /// Largest share of failed samples that is tolerated.
    pub failure_limit: f64,
}

/// A probability with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Probability {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// A quantile with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Quantile {
    /// Share of the distribution below.
    pub probability: f64,
    /// Value, SI.
    pub value: f64,
    /// Standard error, SI.
    pub standard_error: f64,
}

/// Distribution of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Distributed {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Whether it is an absolute temperature.
    pub is_temperature: bool,
    /// Value at the nominal parameters.
    pub nominal: f64,
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean (of independent draws: an upper bound for the other samplings).
    pub mean_standard_error: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Standard error of the standard deviation.
    pub sd_standard_error: f64,
    /// Smallest sample.
    pub minimum: f64,
    /// Largest sample.
    pub maximum: f64,
    /// Quantiles at 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99.
    pub quantiles: Vec<Quantile>,
    /// Edges of the histogram's bins (one more than counts), SI.
    pub histogram_edges: Vec<f64>,
    /// Samples in each bin.
    pub histogram_counts: Vec<u64>,
    /// Values at equally spaced probabilities 0.005, 0.015, ..., 0.995: the distribution function.
    pub cdf: Vec<f64>,
}

/// Probability that a requirement is met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Met {
    /// Name of the requirement, or `all`.
    pub requirement: String,
    /// Probability; failed samples count as not met.
    pub probability: Probability,
    /// Required probability.
    pub required: f64,
    /// The quantity must be at most this, SI.
    pub below: Option<f64>,
    /// The quantity must be at least this, SI.
    pub above: Option<f64>,
    /// Unit of the limit.
    pub unit: String,
    /// Name of the quantity (empty for `all`).
    pub quantity: String,
}

/// Joint distribution of two quantities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Joint {
    /// First quantity.
    pub x: String,
    /// Second quantity.
    pub y: String,
    /// Units of both.
    pub units: [String; 2],
    /// Linear correlation; `None` where one of them does not vary.
    pub correlation: Option<f64>,
    /// Edges of the bins of x.
    pub x_edges: Vec<f64>,
    /// Edges of the bins of y.
    pub y_edges: Vec<f64>,
    /// Counts, by bin of x then bin of y.
    pub counts: Vec<Vec<u64>>,
    /// For each bin of x with samples: middle, mean of y, its 5 % and 95 % quantiles, samples.
    pub conditional: Vec<Conditional>,
}

/// Distribution of y where x lies in a bin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Conditional {
    /// Middle of the bin of x.
    pub x: f64,
    /// Mean of y.
    pub mean: f64,
    /// 5 % quantile of y.
    pub q05: f64,
    /// 95 % quantile of y.
    pub q95: f64,
    /// Samples in the bin.
    pub samples: u64,
}

/// A sample whose solution failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FailedSample {
    /// Index of the sample.
    pub index: u64,
    /// The parameters, SI, by name.
    pub parameters: Vec<(String, f64)>,
    /// Why.
    pub reason: String,
}

/// Share of a quantity's variance that would go if a parameter were known, from the same samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MainEffect {
    /// Quantity.
    pub quantity: String,
    /// Parameter.
    pub parameter: String,
    /// Estimate with its 95 % interval.
    #[serde(flatten)]
    pub estimate: Estimate,
}

/// One environment at one value of the design variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Case {
    /// Environment.
    pub environment: String,
    /// Value of the design variable, SI; `None`: its nominal value.
    pub design_value: Option<f64>,
    /// Distributions, in the order asked for.
    pub quantities: Vec<Distributed>,
    /// Requirements, each and `all` together.
    pub requirements: Vec<Met>,
    /// Joint distributions.
    pub joint: Vec<Joint>,
    /// Main effects by classes of the same samples, at the nominal design value; none with too few samples.
    pub main_effects: Vec<MainEffect>,
    /// Number of failed samples.
    pub failed: u64,
    /// The first failed samples.
    pub failures: Vec<FailedSample>,
}

/// Design value at which a requirement's probability reaches what is required.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Reached {
    /// Environment.
    pub environment: String,
    /// Requirement, or `all`.
    pub requirement: String,
    /// Required probability.
    pub probability: f64,
    /// Design value, SI; `None` where the sweep does not reach it.
    pub design_value: Option<f64>,
    /// Design value's 95 % interval from the sampling error.
    pub interval: Option<[f64; 2]>,
}

/// What is known of the model's discrepancy in a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Discrepancy {
    /// Index of the quantity in the model's list.
    pub quantity: usize,
    /// Standard deviation of what is added to it, normal with mean 0, SI.
    pub sd: f64,
}

/// The inputs of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseInputs {
    /// Environment.
    pub environment: String,
    /// Value of the design variable, SI; `None`: its nominal value.
    pub design_value: Option<f64>,
    /// Inputs by name, SI.
    pub inputs: Vec<(String, f64)>,
}

/// A discrepancy that is added to quantities of each sample, as it belongs to the sample's draw of a posterior.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjustment {
    /// Positions of the quantities.
    pub positions: Vec<usize>,
    /// By case, then by draw of its hyperparameters: its mean at the posterior mean, the slopes of that with the unknowns of
    /// the calibration, and its standard deviation, SI.
    pub cases: Vec<Vec<(f64, Vec<f64>, f64)>>,
    /// For each draw of the posterior the unknowns' deviations from their means.
    pub deviations: Arc<Vec<Vec<f64>>>,
    /// Whether hyperparameters were drawn together with the posterior, a draw each; else any goes with any.
    pub is_paired: bool,
}

/// An error of the model that is added to a quantity: normal with mean 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AddedDiscrepancy {
    /// The quantity.
    pub quantity: String,
    /// Its standard deviation, SI.
    pub sd: f64,
    /// SI unit.
    pub unit: String,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Number of samples a case.
    pub samples: u64,
    /// Sampling, as in the pass file.
    pub sampling: String,
    /// Name of the design variable, if one is swept.
    pub design_variable: Option<String>,
    /// Its unit as the study writes it.
    pub design_unit: String,
    /// The nominal design value first, then the sweep, for each environment.
    pub cases: Vec<Case>,
    /// Where the required probabilities are reached.
    pub reached: Vec<Reached>,
    /// Draws that stood in for priors; errors and intervals are from the number of draws that these are worth.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior_priors: Vec<PosteriorPriorSummary>,
    /// Errors of the model that are added to quantities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub discrepancy: Vec<AddedDiscrepancy>,
    /// Whether the chains behind those draws converged; left out without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
}
