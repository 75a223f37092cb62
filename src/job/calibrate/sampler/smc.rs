//! Sequential Monte Carlo from the prior to the posterior (Del Moral, Doucet and Jasra 2006); its islands are the chains.

use super::{Method, Run};
use crate::inference::sampler::smc::{self, SmcSettings};
use crate::job::JobError;
use crate::job::calibrate::block::Partial;

/// The sampler.
pub(in super::super) struct Smc;

impl Method for Smc {
    fn name(&self) -> &'static str {
        "smc"
    }

    fn about(&self) -> &'static str {
        "Sequential Monte Carlo."
    }

    fn defaults(&self) -> (u64, u64) {
        (0, 1000)
    }

    fn least_draws(&self) -> u64 {
        16
    }

    fn has_warm_up(&self) -> bool {
        false
    }

    fn has_islands(&self) -> bool {
        true
    }

    fn run(&self, run: &Run<'_>) -> Result<Partial, JobError> {
        let spec = &run.calibration.spec;
        let particles = usize::try_from(spec.draws).unwrap_or(usize::MAX);
        let settings = SmcSettings { particles, islands: spec.chains, ..SmcSettings::default() };
        let island = smc::run_island(run.target, &settings, &run.calibration.key, run.index);
        Ok(Partial::Island(Box::new(island.map_err(|error| JobError::Failed(error.to_string()))?)))
    }
}
