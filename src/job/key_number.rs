//! Key numbers of a result: those that a regression test holds against a baseline. Which ones these are, each kind says in
//! one place, `JobKind::key_numbers`; of a kind that names none only the whole result is compared, with the same seed.

use serde::{Deserialize, Serialize};

use crate::statistics::monte_carlo::StandardError;

/// A number of a result with its Monte Carlo error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct KeyNumber {
    /// What it is of: a parameter, two of them, a quantity in an environment.
    pub of: String,
    /// Which number of it, as `mean`, `q95`, `covariance`.
    pub statistic: String,
    /// Unit; empty for a number without.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Its error by Monte Carlo alone; nothing where it is not known, so that it cannot be compared with another seed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<StandardError>,
}

impl KeyNumber {
    /// A number of something, in a unit, with its Monte Carlo error.
    pub fn new(
        of: impl Into<String>,
        statistic: impl Into<String>,
        unit: impl Into<String>,
        value: f64,
        error: Option<StandardError>,
    ) -> Self {
        Self { of: of.into(), statistic: statistic.into(), unit: unit.into(), value, error }
    }

    /// What it is, for people: `Gh, mean`.
    pub fn name(&self) -> String {
        format!("{}, {}", self.of, self.statistic)
    }
}
