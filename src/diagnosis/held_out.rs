//! What the held-out rows say of a set of effects: a paired test of the squared errors, in blocks.

use std::collections::BTreeMap;

use super::output::HeldOutTest;
use super::{Problem, Refit};
use crate::inference::measurement::Rows;
use crate::math::special::student_t_cdf;

/// Probability below which the test speaks against a set.
const AGAINST: f64 = 0.01;
/// Correlation times of a block.
const TIMES_OF_BLOCK: f64 = 3.0;
/// Fewest blocks that are tested.
const LEAST_BLOCKS: usize = 4;

/// Tests whether a set predicts the held-out rows worse than the believed model. A block is a phase, or three
/// correlation times of a transient. `None` where there are too few blocks.
pub(super) fn test(problem: &Problem, believed: &Refit, chosen: &Refit) -> Option<HeldOutTest> {
    let mut blocks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (before, after) in believed.held_out.iter().zip(&chosen.held_out) {
        if before.sigma > 0.0 && before.error.is_finite() && after.error.is_finite() {
            let gain = (before.error * before.error - after.error * after.error) / (before.sigma * before.sigma);
            *blocks.entry((before.measurement, block(problem, before.measurement, before.row))).or_default() += gain;
        }
    }
    let count = blocks.len();
    if count < LEAST_BLOCKS {
        return None;
    }
    let mean = blocks.values().sum::<f64>() / count as f64;
    let square = blocks.values().map(|gain| (gain - mean) * (gain - mean)).sum::<f64>();
    let se = (square / (count * (count - 1)) as f64).sqrt();
    let veto = se > 0.0 && student_t_cdf(mean / se, (count - 1) as f64) < AGAINST;
    Some(HeldOutTest { gain: mean, se, blocks: count as u64, veto })
}

/// Number of the block of a row.
fn block(problem: &Problem, measurement: usize, row: usize) -> usize {
    let measurement = &problem.measurements[measurement];
    match &measurement.rows {
        Rows::Steady(_) => row,
        Rows::Transient { inputs, .. } => {
            let times = measurement.sensors.iter().filter_map(|s| s.correlation_time_s.as_ref().map(|t| t.nominal()));
            let longest = times.fold(0.0, f64::max);
            let span = inputs.times_s.last().unwrap_or(&0.0) - inputs.times_s.first().unwrap_or(&0.0);
            // Errors of a model are correlated where its noise is not: at least a fiftieth of the whole.
            let length = (TIMES_OF_BLOCK * longest).max(0.02 * span).max(f64::MIN_POSITIVE);
            ((inputs.times_s[row] - inputs.times_s.first().unwrap_or(&0.0)) / length) as usize
        }
    }
}
