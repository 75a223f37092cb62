//! Settings and result of experimental goal setting.

use crate::job::propagate::Discrepancy;
use serde::{Deserialize, Serialize};

use crate::job::propagate::Probability;
use crate::statistics::sobol_indices::Estimate;
use crate::study::requirement::{Environment, Requirement};
use crate::study::variable::Sweep;

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Requirements, all of which must be met.
    pub requirements: Vec<Requirement>,
    /// Environments, in all of which they must be met.
    pub environments: Vec<Environment>,
    /// Indices of the parameters whose knowledge is sharpened, in this order; those with the largest main effects where empty.
    pub parameters: Vec<usize>,
    /// Design variable with the ends of its range, if any; requirements are easier to meet towards the second.
    pub design: Option<Sweep>,
    /// Number of samples, a power of two.
    pub samples: u64,
    /// Discrepancies, where a validation experiment found them.
    pub discrepancy: Vec<Discrepancy>,
    /// Largest share of failed solves that is tolerated.
    pub failure_limit: f64,
}

/// Probability of a requirement with prior knowledge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Met {
    /// Requirement.
    pub requirement: String,
    /// Environment.
    pub environment: String,
    /// Quantity.
    pub quantity: String,
    /// Probability; failed samples count as not met.
    pub probability: Probability,
    /// Mean of the quantity, SI.
    pub mean: f64,
    /// Standard deviation of the quantity, SI.
    pub sd: f64,
}

/// The requirement that is met least often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Driving {
    /// Requirement.
    pub requirement: String,
    /// Environment.
    pub environment: String,
    /// Its quantity.
    pub quantity: String,
    /// SI unit of the quantity.
    pub unit: String,
    /// Whether it is an absolute temperature.
    pub is_temperature: bool,
}

/// A parameter by its main effect on the driving quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Leading {
    /// Parameter.
    pub parameter: String,
    /// Unit as the study writes it; the numbers are SI.
    pub unit: String,
    /// Mean of its prior.
    pub mean: f64,
    /// Standard deviation of its prior.
    pub sd: f64,
    /// Main effect from the samples; nothing where there are too few.
    pub main: Option<Estimate>,
}

/// What some knowledge leads to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Level {
    /// Standard deviation that is left, by that of the prior: 1 is the prior, 0 perfect knowledge.
    pub ratio: f64,
    /// Standard deviations that are left, by parameter, SI.
    pub sds: Vec<f64>,
    /// Probability that all requirements are met by the given design.
    pub probability: Probability,
    /// Design value from which on, towards the range's end, the probability is reached; nothing where it was not sought or is not
    /// in the range.
    pub design_value: Option<f64>,
    /// Whether a design value was sought.
    pub is_design_sought: bool,
}

/// Knowledge of some parameters, from little to perfect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Knowledge {
    /// The parameters that are known better; the others keep their priors.
    pub parameters: Vec<String>,
    /// From the largest standard deviation to none.
    pub levels: Vec<Level>,
}

/// The least knowledge with which the given design meets the requirements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Target {
    /// The parameters.
    pub parameters: Vec<String>,
    /// Units as the study writes them.
    pub units: Vec<String>,
    /// Standard deviation that may be left, by that of the prior.
    pub ratio: f64,
    /// Variance that may be left, by that of the prior: the square.
    pub variance_ratio: f64,
    /// Standard deviations that may be left, by parameter, SI.
    pub sds: Vec<f64>,
    /// Probability then.
    pub probability: Probability,
}

/// What the knowledge would lead to, averaged over what the truth may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Truths {
    /// The parameters that an experiment measures.
    pub parameters: Vec<String>,
    /// Standard deviation that the experiment leaves, by that of the prior.
    pub ratio: f64,
    /// Truths drawn from the prior.
    pub count: u64,
    /// Share of them for which the given design then shows the required probability.
    pub reaching: Probability,
    /// Design value by truth, SI, sorted; the range's end does not reach it for the others.
    pub design_values: Vec<f64>,
    /// Mean of the design values; nothing where some truth does not reach it within the range.
    pub mean_design_value: Option<f64>,
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Next {
    /// An experiment that infers the leading parameters.
    ParameterInference,
    /// An experiment that validates the model near the conditions of use.
    Validation,
    /// Nothing: the requirements are met, the model's discrepancy included.
    Done,
    /// Another design: no knowledge of the leading parameters is enough.
    Redesign,
}

/// Advice with the numbers behind it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Advice {
    /// What to do next.
    pub next: Next,
    /// Why.
    pub reasons: Vec<String>,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Samples a probability.
    pub samples: u64,
    /// Required probability of all requirements together.
    pub required: f64,
    /// Design variable, if any.
    pub design_variable: Option<String>,
    /// Its unit as the study writes it; its values are SI.
    pub design_unit: String,
    /// The given value.
    pub design_nominal: Option<f64>,
    /// Where its search starts and ends.
    pub design_range: Option<[f64; 2]>,
    /// Probability that all requirements are met with prior knowledge.
    pub probability: Probability,
    /// Each requirement in each environment.
    pub requirements: Vec<Met>,
    /// The one that is met least often.
    pub driving: Driving,
    /// Parameters by their main effect on the driving quantity, largest first.
    pub leading: Vec<Leading>,
    /// Design value that prior knowledge reaches.
    pub prior_design_value: Option<f64>,
    /// What sharper knowledge leads to: of the leading parameter, of the two leading ones, ...
    pub knowledge: Vec<Knowledge>,
    /// The least knowledge that is enough, where some is and is needed.
    pub target: Option<Target>,
    /// Averages over truths.
    pub truths: Option<Truths>,
    /// The largest standard deviation of a discrepancy in the driving quantity that leaves the required probability, with prior
    /// knowledge; nothing where the probability is missed without one. SI.
    pub tolerable_discrepancy: Option<f64>,
    /// Discrepancies that are part of every probability: quantity and standard deviation, SI.
    pub discrepancy: Vec<(String, f64)>,
    /// Failed solves of all.
    pub failed: u64,
    /// Solves of all.
    pub solves: u64,
    /// What to do next.
    pub advice: Advice,
}
