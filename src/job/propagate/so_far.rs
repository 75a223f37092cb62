//! What a part of the samples already says: the share that meets each requirement, for people who wait. It is stored nowhere.

use super::Propagate;
use super::block::{BlockInput, BlockOutput};
use crate::statistics::interval::Interval;

/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

impl Propagate {
    /// A line for each requirement in each environment at its given design.
    pub(super) fn met_so_far(&self, blocks: &[(BlockInput, BlockOutput)]) -> Vec<String> {
        let mut lines = Vec::new();
        for case in (0..self.cases()).filter(|&case| self.design(case).is_none()) {
            for requirement in &self.spec.requirements {
                let position = self.spec.quantities.iter().position(|&quantity| quantity == requirement.quantity);
                let Some(position) = position else { continue };
                let (mut met, mut samples) = (0_u64, 0_u64);
                for (input, output) in blocks.iter().filter(|(input, _)| input.case == case) {
                    let count = usize::try_from(input.count).unwrap_or(usize::MAX);
                    let values = output.values.chunks(count.max(1)).nth(position).unwrap_or_default();
                    met += values.iter().filter(|value| requirement.met(**value)).count() as u64;
                    samples += values.len() as u64;
                }
                if samples == 0 {
                    continue;
                }
                // Samples count as independent, which the points of a Sobol set are better than.
                let Interval { lower, upper } = Interval::wilson(met, samples, CONFIDENCE);
                lines.push(format!(
                    "so far `{}` is met in `{}` with a probability of {:.4} (95 % interval {lower:.4} to {upper:.4}), by {samples} of {} samples",
                    requirement.name,
                    self.case_name(case).0,
                    met as f64 / samples as f64,
                    self.spec.samples
                ));
            }
        }
        lines
    }
}
