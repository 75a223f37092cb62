//! Design variables: parameters or inputs whose value is chosen, and the values that they take.

use serde::{Deserialize, Serialize};

/// What a design variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variable {
    /// Index of a parameter.
    Parameter(usize),
    /// Index of an input.
    Input(usize),
}

/// Values that a design variable takes one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Name of the parameter or input.
    pub name: String,
    /// Unit as the study writes it, for people.
    pub unit: String,
    /// Which one.
    pub variable: Variable,
    /// Values, SI, increasing.
    pub values: Vec<f64>,
}
