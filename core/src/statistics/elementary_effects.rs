//! Elementary effects (Morris 1991): one-at-a-time steps along trajectories over a grid of the unit cube.
//!
//! A grid has four levels, the middles of four equal slices, so that no prior without bounds is asked for an end; a step leads
//! half the cube up or down, which visits all levels equally often. `mu*` is the mean size of a coordinate's effects
//! (Campolongo, Cariboni & Saltelli 2007), `sigma` their standard deviation: large beside `mu*` where the effect is not straight or
//! depends on other coordinates.

use serde::{Deserialize, Serialize};

use super::Moments;
use crate::random::StreamKey;

/// Levels of the grid.
pub const LEVELS: usize = 4;
/// Length of a step.
pub const STEP: f64 = 0.5;

/// A path over the grid: where it starts, and the coordinate that each step changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Start, in the open unit cube.
    pub start: Vec<f64>,
    /// Coordinates in the order in which they step, each once.
    pub order: Vec<usize>,
}

impl Trajectory {
    /// The trajectory of an index, from its own stream of the key.
    pub fn new(key: &StreamKey, index: u64, coordinates: usize) -> Self {
        let mut stream = key.stream(index);
        let start = (0..coordinates).map(|_| (stream.below(LEVELS) as f64 + 0.5) / LEVELS as f64).collect();
        let mut order: Vec<usize> = (0..coordinates).collect();
        for last in (1..coordinates).rev() {
            order.swap(last, stream.below(last + 1));
        }
        Self { start, order }
    }

    /// The step that a coordinate takes: up from the lower half, down from the upper.
    pub fn step(&self, coordinate: usize) -> f64 {
        if self.start[coordinate] < 0.5 { STEP } else { -STEP }
    }
}

/// What elementary effects tell of a coordinate, in the quantity's unit for the whole range of the coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ElementaryEffect {
    /// Mean.
    pub mu: f64,
    /// Mean of the sizes.
    pub mu_star: f64,
    /// Standard error of `mu_star`.
    pub mu_star_standard_error: f64,
    /// Standard deviation.
    pub sigma: f64,
}

impl ElementaryEffect {
    /// Summary of a coordinate's effects, one a trajectory.
    pub fn of(effects: &[f64]) -> Self {
        let sizes: Vec<f64> = effects.iter().map(|effect| effect.abs()).collect();
        let (all, sizes) = (Moments::of(effects), Moments::of(&sizes));
        let mu_star_standard_error = sizes.mean_standard_error();
        Self { mu: all.mean(), mu_star: sizes.mean(), mu_star_standard_error, sigma: all.sd() }
    }
}
