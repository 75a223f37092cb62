//! Metropolis with proposals about the most probable point (Tierney 1994): one likelihood a draw.

use super::{Method, Run};
use crate::inference::sampler::independence::{self, IndependenceSettings};
use crate::job::JobError;
use crate::job::calibrate::block::Partial;

/// Steps of a chain after which its state may be kept, each time.
const STEPS: u64 = 50;

/// The sampler.
pub(in super::super) struct IndependenceMetropolis;

impl Method for IndependenceMetropolis {
    fn name(&self) -> &'static str {
        "independence-metropolis"
    }

    fn about(&self) -> &'static str {
        "Metropolis with proposals about the most probable point, one likelihood a draw: for long records, whose posteriors are nearly normal. It sees one mode only."
    }

    fn defaults(&self) -> (u64, u64) {
        (100, 2000)
    }

    fn run(&self, run: &Run<'_>) -> Result<Partial, JobError> {
        let (warm_up, draws) = (run.calibration.spec.warmup, run.calibration.spec.draws);
        let about = IndependenceSettings::about(run.estimate.normal_approximation());
        let settings = IndependenceSettings { warm_up, draws, ..about };
        run.in_parts(warm_up + draws, STEPS, |parts| {
            independence::sample_in_parts(run.target, &settings, &run.calibration.key, run.index, run.start, parts)
        })
    }
}
