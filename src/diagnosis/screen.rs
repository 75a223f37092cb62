//! Screening.
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::engine::{Diagnosis, SettledSensor};
use super::{Problem, Refit};

/// An effect that stands out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lead {
    /// Position of the candidate.
    pub candidate: usize,
    /// By how much it lowers the sum of squares, less two for each further freedom that it takes.
    pub fall: f64,
    /// Starts of its parameters by name, SI.
    pub starts: Vec<BTreeMap<String, f64>>,
}

/// A test of the family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilyTest {
    /// What was tested.
    pub name: String,
    /// What it found worst.
    pub at: String,
    /// p.
    pub p: f64,
}

/// The tests together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Family {
    /// Family-wise p.
    pub p: f64,
    /// Its members.
    pub tests: Vec<FamilyTest>,
}

/// What screening found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Screening {
    /// Single effects, best first.
    pub leads: Vec<Lead>,
    /// Pairs, best first.
    pub pairs: Vec<[Lead; 2]>,
    /// Number of pairs.
    pub pairs_screened: u64,
    /// The tests.
    pub family: Family,
    /// What the data cannot see: position and why.
    pub unseen: Vec<(usize, String)>,
    /// What would have been seen: position, amplitude and unit.
    pub detectable: Vec<(usize, f64, String)>,
}

impl Diagnosis {
    pub(super) fn settle_noise(&self, _declared: &Refit) -> Result<Vec<SettledSensor>, String> {
        Ok(Vec::new())
    }

    pub(super) fn screen_problem(&self, _problem: &Problem, _refit: &Refit, _whole: bool) -> Result<Screening, String> {
        Err(String::new())
    }
}
