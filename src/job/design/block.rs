//! Blocks of a design: what is known when a stage begins, what a block is to do, and what it found.

use serde::{Deserialize, Serialize};

use super::output::{Estimator, Output, Phase};
use crate::inference::information::estimate::Replicate;
use crate::job::JobError;
use crate::job::stored::{Block, split_numbers, unreadable, with_numbers};

/// The result so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub output: Output,
    /// The estimator at work, never `automatic`.
    pub estimator: Estimator,
    /// Of each candidate, by that estimator.
    pub replicates: Vec<Vec<Replicate>>,
    /// Phases that a search found: candidates after those of the settings.
    pub found: Vec<Phase>,
    /// What other estimators gave, which were not good.
    pub tried: Vec<(Estimator, Vec<Vec<Replicate>>)>,
    /// Whether the choice of further phases, and of sensors, has ended early.
    pub ended: [bool; 2],
}

/// What is known when a stage begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// The result so far.
    pub state: State,
    /// Noise-free readings of each candidate, `samples x sensors`; none where too few samples have a solution.
    pub readings: Vec<Vec<f64>>,
}

/// All but the readings with the lengths of these, then the readings.
impl Block for Known {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        let lengths: Vec<usize> = self.readings.iter().map(Vec::len).collect();
        with_numbers(&(self.state, lengths), &self.readings.concat())
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((state, lengths), numbers): ((State, Vec<usize>), _) = split_numbers(bytes, stage)?;
        let (mut readings, mut rest) = (Vec::new(), numbers.as_slice());
        for length in lengths {
            let candidate_readings;
            (candidate_readings, rest) =
                rest.split_at_checked(length).ok_or_else(|| unreadable(stage, "its readings are cut off"))?;
            readings.push(candidate_readings.to_vec());
        }
        if rest.is_empty() { Ok(Self { state, readings }) } else { Err(unreadable(stage, "it is too long")) }
    }
}

/// What a set of readings is looked at for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Purpose {
    /// A candidate phase alone.
    Candidate,
    /// A candidate phase added to those that were picked.
    Phase,
    /// A sensor at the best candidate, added to those that were chosen.
    Sensor,
}

/// A set of readings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Set {
    pub purpose: Purpose,
    /// Candidates whose phases are done together; the last is the new one.
    pub phases: Vec<usize>,
    /// Sensors that are read.
    pub sensors: Vec<usize>,
}

/// What a block is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Task {
    /// Readings of a candidate.
    Predict { candidate: usize },
    /// Information of a set of readings: first replicate and number of replicates.
    Inform { set: Set, replicates: [usize; 2] },
    /// Readings of a phase between the values of the grid, and its information.
    Search { phase: Phase },
}

/// What came out beside the predictions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PredictHead {
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

/// Information of a set of readings by some replicates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Information {
    pub replicates: Vec<Replicate>,
    pub solutions: u64,
}

/// What a block found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Of a phase that was solved.
    pub head: Option<PredictHead>,
    pub information: Information,
    /// Noise-free readings of a phase that was solved: `samples x sensors`.
    pub readings: Vec<f64>,
}

/// All but the readings, then these.
impl Block for Found {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        with_numbers(&(self.head, self.information), &self.readings)
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let ((head, information), readings) = split_numbers(bytes, stage)?;
        Ok(Self { head, information, readings })
    }
}
