//! What the system must satisfy.

use serde::{Deserialize, Serialize};

/// Stands for all requirements together in results.
pub const ALL: &str = "all";

/// A limit on a quantity, with the probability with which it must be met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// Name.
    pub name: String,
    /// Index of the quantity in the model's list.
    pub quantity: usize,
    /// The quantity must be at most this, SI.
    pub below: Option<f64>,
    /// The quantity must be at least this, SI.
    pub above: Option<f64>,
    /// Required probability.
    pub probability: f64,
}

impl Requirement {
    /// Whether a value meets the requirement; a failed solution (NaN) does not.
    pub fn met(&self, value: f64) -> bool {
        self.below.is_none_or(|limit| value <= limit)
            && self.above.is_none_or(|limit| value >= limit)
            && !value.is_nan()
    }
}

/// What a requirement says and where it comes from, for people; no job knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statement {
    /// Name of the requirement.
    pub requirement: String,
    /// In words; may be empty.
    pub text: String,
    /// Where it comes from; may be empty.
    pub source: String,
}

/// A named set of input values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Name.
    pub name: String,
    /// Value of every input of the model, SI.
    pub inputs: Vec<f64>,
}
