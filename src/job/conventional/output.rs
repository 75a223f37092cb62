//! Settings and result of the conventional way.

use crate::job::{JobError, correlate};
use crate::study::rule::Rule;
use serde::{Deserialize, Serialize};

use crate::study::requirement::{Environment, Requirement};
use crate::study::variable::Sweep;

/// The parameters at which a rule looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Nominal values.
    Nominal,
    /// Every uncertain parameter at the end of its prior that is worst for the requirement.
    StackedWorstCase,
}

impl Basis {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::StackedWorstCase => "stacked worst case",
        }
    }
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// The rules, in order.
    pub rules: Vec<Rule>,
    /// The environments, each sized for.
    pub environments: Vec<Environment>,
    /// The requirements, each sized for.
    pub requirements: Vec<Requirement>,
    /// The design variable, with the range in which the size is sought (first and last value); rules pass towards its end.
    pub design: Sweep,
    /// Names of the parameters and inputs that are heat loads (for heat-load margins).
    pub heat_loads: Vec<crate::study::variable::Variable>,
    /// The `correlate` job of this pass whose values stand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<String>,
    /// The earlier pass whose knowledge is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub knowledge: Option<Knowledge>,
}

/// What was known in an earlier pass of the parameters of this one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Knowledge {
    /// The pass's file.
    pub pass: String,
    /// Index of a parameter, its nominal value and its prior then, SI.
    pub parameters: Vec<(usize, f64, crate::random::Distribution)>,
}

/// What a rule leads to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Size {
    /// The rule.
    pub rule: Rule,
    /// The parameters looked at.
    pub basis: Basis,
    /// Environment.
    pub environment: String,
    /// Requirement.
    pub requirement: String,
    /// Design value from which on, towards the range's end, the rule passes, SI; `None` where none does.
    pub size: Option<f64>,
    /// The quantity at the nominal design value, with the rule's parameters, SI.
    pub prediction: f64,
    /// Margin left at the nominal design value against the rule's, SI (negative: it fails).
    pub margin: f64,
    /// Whether the nominal design passes.
    pub passes: bool,
}

/// End of its prior at which a parameter is worst.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct WorstEnd {
    /// Requirement.
    pub requirement: String,
    /// Parameter.
    pub parameter: String,
    /// Unit as written.
    pub unit: String,
    /// Nominal value, SI.
    pub nominal: f64,
    /// Worst value, SI.
    pub worst: f64,
    /// Change of the quantity from nominal to worst, this parameter alone, SI.
    pub effect: f64,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Design variable.
    pub design_variable: String,
    /// Its unit as the study writes it.
    pub design_unit: String,
    /// Its nominal value, SI.
    pub design_nominal: f64,
    /// The range in which sizes were sought, SI: rules pass towards its second end.
    pub design_range: [f64; 2],
    /// Unit of the limits, SI.
    pub unit: String,
    /// Whether the quantity is an absolute temperature.
    pub is_temperature: bool,
    /// The limit, SI, by requirement name.
    pub limits: Vec<(String, f64)>,
    /// What each rule leads to.
    pub sizes: Vec<Size>,
    /// The stack of worst ends.
    pub worst_case: Vec<WorstEnd>,
    /// The correlation whose values stand, and how it changed parameters; before any where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<Correlation>,
    /// The earlier pass whose nominal values and priors were taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priors_of: Option<String>,
    /// Whether ends of priors are those of draws of a posterior.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub from_draws: bool,
}

/// A correlation behind sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Correlation {
    /// The job.
    pub job: String,
    /// How parameters were changed, in words.
    pub method: String,
    /// Whether its criteria were met.
    pub met: bool,
    /// The parameters with their values, SI.
    pub values: Vec<(String, f64)>,
}

/// The part of a correlation's result that is used.
#[derive(Deserialize)]
struct Correlated {
    method: correlate::Method,
    ended: correlate::Ended,
    parameters: Vec<correlate::Correlated>,
}

impl Correlation {
    /// From the result of the correlation of this name.
    ///
    /// # Errors
    /// A result without its values.
    pub fn from_result(job: &str, result: &serde_json::Value) -> Result<Self, JobError> {
        let own = Correlated::deserialize(result)
            .map_err(|error| JobError::Failed(format!("the result of `{job}` has no values: {error}")))?;
        Ok(Self {
            job: job.to_owned(),
            method: own.method.words().to_owned(),
            met: own.ended != correlate::Ended::NotMet,
            values: own.parameters.into_iter().map(|own| (own.name, own.after)).collect(),
        })
    }
}

impl Output {
    /// Whether a size is the largest design value that passes, not the smallest: the range falls.
    pub fn seeks_largest(&self) -> bool {
        self.design_range[0] > self.design_range[1]
    }

    /// The size that meets every requirement of an environment under one rule and basis: the one nearest the range's end,
    /// `None` where a requirement has none.
    pub fn governing(&self, environment: &str, rule: &str, basis: Basis) -> Option<&Size> {
        let matching_sizes =
            || self.sizes.iter().filter(|s| s.environment == environment && s.rule.name == rule && s.basis == basis);
        let from_end = |size: &Size| size.size.map_or(f64::NEG_INFINITY, |value| (value - self.design_range[1]).abs());
        matching_sizes().min_by(|a, b| from_end(a).total_cmp(&from_end(b)))
    }
}
