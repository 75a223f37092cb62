//! Key numbers of a result: those that a regression test holds against a baseline. Which ones these are, each kind says in
//! one place, `JobKind::key_numbers`; of a kind that names none only the whole result is compared, with the same seed.

use serde::{Deserialize, Serialize};

use crate::statistics::monte_carlo::StandardError;

/// Standard errors that a tolerance is worth: of a difference six, times the square root of 2.
const SEARCHED: f64 = 6.0 * std::f64::consts::SQRT_2;

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

    /// A number that no seed moves: an error of 0, so that any change beyond rounding is found with another seed too.
    pub fn exact(of: impl Into<String>, statistic: impl Into<String>, unit: impl Into<String>, value: f64) -> Self {
        Self::new(of, statistic, unit, value, StandardError::new(0.0, None))
    }

    /// A number at the end of a search that begins at points drawn with the seed: a change by `tolerance`, in its unit, is
    /// found, and what searches leave undecided is far below. About six standard errors of a difference stand for it.
    pub fn searched(
        of: impl Into<String>,
        statistic: impl Into<String>,
        unit: impl Into<String>,
        value: f64,
        tolerance: f64,
    ) -> Self {
        Self::new(of, statistic, unit, value, StandardError::new(tolerance / SEARCHED, None))
    }

    /// What it is, for people: `Gh, mean`.
    pub fn name(&self) -> String {
        format!("{}, {}", self.of, self.statistic)
    }
}
