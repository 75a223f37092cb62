//! Settings and result of margins from history.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A predicted temperature that was later measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Class, by which rows are judged apart; empty where the file has none.
    pub class: String,
    /// Program; empty where the file has none.
    pub program: String,
    /// Measured minus predicted, K.
    pub difference_k: f64,
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// File, for people.
    pub file: String,
    /// SHA-256 of it.
    pub sha256: String,
    /// Its rows.
    pub comparisons: Vec<Comparison>,
    /// Whether the file says which program a row is of.
    pub has_programs: bool,
    /// Share of the differences that a margin must hold.
    pub capture: f64,
    /// Confidence of its bounds.
    pub confidence: f64,
    /// Margins of temperature that are held against the history: name of the rule, K.
    pub rules: Vec<(String, f64)>,
}

/// How many of the differences a margin holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Held {
    /// Rule.
    pub rule: String,
    /// Its margin, K.
    pub margin_k: f64,
    /// Differences whose magnitude is at most the margin.
    pub inside: u64,
    /// The share of them in the population: Clopper and Pearson's interval at the stated confidence.
    pub interval: [f64; 2],
}

/// The margins of one class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Group {
    /// Class; `None` for all rows together.
    pub class: Option<String>,
    /// Differences.
    pub comparisons: u64,
    /// Programs that they are of; `None` where that is not known.
    pub programs: Option<u64>,
    /// Mean of measured minus predicted, K.
    pub mean_k: f64,
    /// Standard deviation, K; `None` of a single one.
    pub sd_k: Option<f64>,
    /// Smallest and largest difference, K.
    pub range_k: [f64; 2],
    /// The margin either way that holds the share of a normal distribution with this mean and standard deviation, K.
    pub margin_k: Option<f64>,
    /// What holds the share with the stated confidence, K: the mean's magnitude and Howe's factor times the standard deviation.
    pub bound_k: Option<f64>,
    /// The same with only as many values as there are programs, K: all differences of a program count as one.
    pub bound_by_program_k: Option<f64>,
    /// What holds the share of any distribution with the stated confidence, K: an order statistic of the magnitudes. `None` where
    /// there are too few.
    pub distribution_free_k: Option<f64>,
    /// Share of the differences within `margin_k`.
    pub within_margin: Option<f64>,
    /// What margins by rule hold.
    pub rules: Vec<Held>,
    /// Edges of the histogram's bins, K (one more than counts).
    pub edges_k: Vec<f64>,
    /// Differences in each bin.
    pub counts: Vec<u64>,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Output {
    /// File.
    pub file: String,
    /// Share of the differences that a margin must hold.
    pub capture: f64,
    /// Confidence of its bounds.
    pub confidence: f64,
    /// Fewest differences that a bound for any distribution needs.
    pub fewest_distribution_free: u64,
    /// All rows together, then class by class in the order of the file.
    pub groups: Vec<Group>,
    /// What the reader must know.
    pub findings: Vec<String>,
}
