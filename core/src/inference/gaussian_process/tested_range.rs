//! Where a prediction leaves the range that was tested.
//!
//! A range is the box of the tested values, input by input. A point beside the points with values in lengths of the process is
//! given by [`super::process::Process::nearest`].

/// Share of a range's width that rounding may take a point beyond it.
const ROUNDING: f64 = 1e-9;

/// Values of an input over a test.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct TestedRange {
    /// The input.
    pub input: String,
    /// Its SI unit.
    pub unit: String,
    /// Smallest value, SI.
    pub lower: f64,
    /// Largest value, SI.
    pub upper: f64,
}

/// A value outside the tested range.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Outside {
    /// The input.
    pub input: String,
    /// Its SI unit.
    pub unit: String,
    /// The value, SI.
    pub value: f64,
    /// What was tested, SI.
    pub tested: [f64; 2],
    /// By how many widths of the tested range it lies beyond; `None` where only one value was tested.
    pub beyond: Option<f64>,
}

impl TestedRange {
    /// The value, if it lies outside.
    pub fn outside(&self, value: f64) -> Option<Outside> {
        let (width, scale) = (self.upper - self.lower, self.lower.abs().max(self.upper.abs()));
        let slack = ROUNDING * if width > 0.0 { width } else { scale };
        let distance = (self.lower - value).max(value - self.upper);
        // What is no number lies outside too.
        if distance <= slack {
            return None;
        }
        Some(Outside {
            input: self.input.clone(),
            unit: self.unit.clone(),
            value,
            tested: [self.lower, self.upper],
            beyond: (width > 0.0).then(|| distance / width),
        })
    }
}
