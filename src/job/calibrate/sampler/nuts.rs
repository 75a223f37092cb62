//! The No-U-Turn sampler (Hoffman and Gelman 2014).

use super::{Method, Run};
use crate::inference::sampler::nuts::{self, NutsSettings};
use crate::job::JobError;
use crate::job::calibrate::block::Partial;

/// Transitions of a chain after which its state may be kept, each time.
const TRANSITIONS: u64 = 10;

/// The sampler.
pub(in super::super) struct Nuts;

impl Method for Nuts {
    fn name(&self) -> &'static str {
        "nuts"
    }

    fn about(&self) -> &'static str {
        "The No-U-Turn sampler."
    }

    fn defaults(&self) -> (u64, u64) {
        (500, 1000)
    }

    fn has_acceptance(&self) -> bool {
        true
    }

    fn run(&self, run: &Run<'_>) -> Result<Partial, JobError> {
        let spec = &run.calibration.spec;
        let (warm_up, draws, normal) = (spec.warmup, spec.draws, Some(run.estimate.normal_approximation()));
        let mut settings = NutsSettings { warm_up, draws, normal, ..NutsSettings::default() };
        settings.acceptance = spec.acceptance.unwrap_or(settings.acceptance);
        run.in_parts(warm_up + draws, TRANSITIONS, |parts| {
            nuts::sample_in_parts(run.target, &settings, &run.calibration.key, run.index, run.start, parts)
        })
    }
}
