//! Settings of a diagnosis.

use serde::{Deserialize, Serialize};

/// Settings of a diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Most effects at once.
    pub most: u64,
    /// Probability, over all tests, of finding something where nothing is missing.
    pub false_alarm: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { most: 3, false_alarm: 0.005 }
    }
}
