//! Blocks of a design: what each is given and gives back, with readings behind it.

use serde::{Deserialize, Serialize};

use super::State;
use super::output::{Estimator, Phase};
use crate::inference::information::estimate::Replicate;

/// A block of predictions: all samples of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PredictInput {
    pub candidate: usize,
}

/// What came out beside the predictions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PredictHead {
    /// Samples without a solution.
    pub failed: u64,
    /// Samples outside red, and outside yellow limits.
    pub outside: [u64; 2],
    /// How often each node was outside its red or yellow limits.
    pub nodes: Vec<u64>,
    /// Readings by unknowns at nominal parameters: change for one prior standard deviation, SI; empty where the nominal
    /// state has no solution.
    pub changes: Vec<f64>,
}

/// What a block of information is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Purpose {
    /// A candidate phase, alone or added to those that were picked.
    Phase,
    /// A sensor at the best candidate, added to those that were chosen.
    Sensor,
    /// A phase between the values of the grid: its readings are not known yet.
    Search,
    /// Nothing: it carries the result so far.
    Carry,
}

/// A block of information. The numbers behind it are the noise-free readings of its phases, one after the other:
/// `samples x sensors` each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct InformationInput {
    pub purpose: Purpose,
    /// Candidates whose phases are done together; the last is the new one.
    pub phases: Vec<usize>,
    /// Sensors that are read.
    pub sensors: Vec<usize>,
    /// How the information is estimated.
    pub estimator: Estimator,
    /// First replicate and number of replicates.
    pub replicates: [usize; 2],
    /// Phases that a search found: candidates after those of the settings.
    pub found: Vec<Phase>,
    /// The result so far.
    pub carry: Option<Box<State>>,
}

impl InformationInput {
    /// The same without candidates and without what it carries.
    pub fn shell(&self) -> Self {
        Self {
            purpose: Purpose::Phase,
            phases: Vec::new(),
            sensors: self.sensors.clone(),
            estimator: self.estimator,
            replicates: self.replicates,
            found: Vec::new(),
            carry: None,
        }
    }
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct InformationOutput {
    /// Of a phase of a search, whose readings are the numbers behind it.
    pub head: Option<PredictHead>,
    pub replicates: Vec<Replicate>,
    pub solutions: u64,
}
