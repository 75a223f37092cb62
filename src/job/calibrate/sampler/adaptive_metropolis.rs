//! Adaptive Metropolis with a second, smaller proposal (Haario, Saksman and Tamminen 2001; Haario et al. 2006).

use super::{Method, Run};
use crate::inference::sampler::metropolis::{self, MetropolisSettings};
use crate::job::JobError;
use crate::job::calibrate::block::Partial;

/// Steps of a chain after which its state may be kept, each time.
const STEPS: u64 = 100;

/// The sampler.
pub(in super::super) struct AdaptiveMetropolis;

impl Method for AdaptiveMetropolis {
    fn name(&self) -> &'static str {
        "adaptive-metropolis"
    }

    fn about(&self) -> &'static str {
        "Adaptive Metropolis."
    }

    fn defaults(&self) -> (u64, u64) {
        (5000, 5000)
    }

    fn run(&self, run: &Run<'_>) -> Result<Partial, JobError> {
        let (warm_up, draws) = (run.calibration.spec.warmup, run.calibration.spec.draws);
        let settings = MetropolisSettings { warm_up, draws, ..MetropolisSettings::default() };
        run.in_parts(warm_up + draws * settings.thin, STEPS, |parts| {
            metropolis::sample_in_parts(run.target, &settings, &run.calibration.key, run.index, run.start, parts)
        })
    }
}
