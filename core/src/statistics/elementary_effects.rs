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
const LEVELS: usize = 4;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trajectories_step_every_coordinate_once_and_stay_inside() {
        let key = StreamKey::new(1, "t", "t");
        let mut visits = [0; LEVELS];
        for index in 0..400 {
            let trajectory = Trajectory::new(&key, index, 5);
            let mut order = trajectory.order.clone();
            order.sort_unstable();
            assert_eq!(order, [0, 1, 2, 3, 4]);
            for j in 0..5 {
                let end = trajectory.start[j] + trajectory.step(j);
                assert!(0.0 < end && end < 1.0);
                visits[(trajectory.start[j] * 4.0) as usize] += 1;
            }
        }
        // 2000 visits of four levels: 500 each, five standard deviations 97.
        assert!(visits.iter().all(|&n: &i32| (n - 500).abs() < 97), "{visits:?}");
        assert_eq!(Trajectory::new(&key, 7, 5), Trajectory::new(&key, 7, 5));
    }

    #[test]
    fn a_line_has_one_effect_and_an_interaction_scatter() {
        // f = 3 x + 2 x y: effect of x = 3 + 2 y with y in 1/8, ..., 7/8: mean 4, of y = 2 x: mean 1.
        let key = StreamKey::new(2, "t", "t");
        let f = |x: &[f64]| 3.0 * x[0] + 2.0 * x[0] * x[1];
        let mut effects = [Vec::new(), Vec::new()];
        for index in 0..2000 {
            let trajectory = Trajectory::new(&key, index, 2);
            let mut at = trajectory.start.clone();
            for &j in &trajectory.order {
                let before = f(&at);
                at[j] += trajectory.step(j);
                effects[j].push((f(&at) - before) / trajectory.step(j));
            }
        }
        let [x, y] = effects.map(|effects| ElementaryEffect::of(&effects));
        // Standard deviation of 2 y over the levels: 2 sqrt(5 / 64) = 0.559; five standard errors of 2000: 0.0625.
        assert!((x.mu_star - 4.0).abs() < 0.0625 && (y.mu_star - 1.0).abs() < 0.0625, "{x:?} {y:?}");
        assert!((x.sigma - 0.559).abs() < 0.02 && (x.mu - x.mu_star).abs() < 1e-12);
    }
}
