//! Settings of a diagnosis.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Settings of a diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Most effects at once.
    pub most: u64,
    /// Probability, over all tests, of finding something where nothing is missing.
    pub false_alarm: f64,
    /// Probabilities beforehand that kinds of effects are missing, by their names, where they are not those of all.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub missing_probability: BTreeMap<String, f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { most: 3, false_alarm: 0.005, missing_probability: BTreeMap::new() }
    }
}
