//! Blocks of a sensitivity analysis: what each is to do, what it found, and all that was found so far.

use serde::{Deserialize, Serialize};

use super::output::{FailedSolve, Local};
use crate::statistics::sobol_indices::SobolSums;

/// What a block is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// Derivatives at the nominal parameters.
    Local,
    /// Trajectories `first` to `first + count - 1`.
    Morris {
        /// First trajectory.
        first: u64,
        /// How many.
        count: u64,
    },
    /// Rows of a scramble.
    Sobol {
        /// Scramble.
        scramble: u64,
        /// First row.
        first: u64,
        /// How many.
        count: u64,
    },
    /// Squared derivatives at the first points of a scramble.
    Derivative {
        /// Scramble.
        scramble: u64,
        /// How many points.
        count: u64,
    },
}

/// A block's input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockInput {
    /// Position of the environment.
    pub case: usize,
    /// What to do.
    pub work: Work,
}

/// Sums of squared derivatives over points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Squares {
    /// Points that were solved.
    pub points: u64,
    /// By quantity then parameter: sum of the squared derivative times the prior's constant.
    pub weighted: Vec<f64>,
    /// By quantity then parameter: sum of the squared derivative.
    pub plain: Vec<f64>,
    /// By quantity: mean and variance of the values.
    pub moments: Vec<[f64; 2]>,
}

/// What was found in one scramble.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfScramble {
    /// Sums by quantity; empty before the first rows.
    pub sums: Vec<SobolSums>,
    /// Rows left out.
    pub left_out: u64,
}

/// What was found in an environment, by one block or by all so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Solves.
    pub solves: u64,
    /// Failed solves.
    pub failed: u64,
    /// The first failed solves.
    pub failures: Vec<FailedSolve>,
    /// Derivatives by quantity then parameter.
    pub local: Vec<Local>,
    /// Elementary effects by trajectory, quantity, parameter; trajectories that failed are left out.
    pub morris: Vec<f64>,
    /// Trajectories left out.
    pub trajectories_left_out: u64,
    /// Rows by scramble.
    pub scrambles: Vec<OfScramble>,
    /// Squared derivatives by scramble.
    pub squares: Vec<Squares>,
    /// By quantity then row: values at the first points of the first scramble, nothing where the row failed.
    pub sample: Vec<Option<f64>>,
}

/// Failed solves kept with their parameters, a block and an environment.
pub const FAILURES_KEPT: usize = 20;

impl Found {
    /// Takes in what a later block found.
    pub fn absorb(&mut self, work: &Work, block: Self) {
        self.solves += block.solves;
        self.failed += block.failed;
        self.failures.extend(block.failures);
        self.failures.truncate(FAILURES_KEPT);
        match *work {
            Work::Local => self.local = block.local,
            Work::Morris { .. } => {
                self.morris.extend(block.morris);
                self.trajectories_left_out += block.trajectories_left_out;
            }
            Work::Sobol { scramble, .. } => {
                let place = usize::try_from(scramble).unwrap_or(usize::MAX);
                while self.scrambles.len() <= place {
                    self.scrambles.push(OfScramble::default());
                }
                let mine = &mut self.scrambles[place];
                for theirs in block.scrambles {
                    mine.left_out += theirs.left_out;
                    if mine.sums.is_empty() {
                        mine.sums = theirs.sums;
                    } else {
                        mine.sums.iter_mut().zip(&theirs.sums).for_each(|(mine, theirs)| mine.merge(theirs));
                    }
                }
                if self.sample.is_empty() {
                    self.sample = block.sample;
                }
            }
            Work::Derivative { .. } => self.squares.extend(block.squares),
        }
    }
}
