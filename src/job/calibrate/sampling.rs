//! Where chains start, and what runs them: chains, islands of particles, the evidence.

use super::block::{Partial, State, Task};
use super::{Calibrate, SAMPLE, Sampler};
use crate::inference::chains::{Chain, SampleError};
use crate::inference::importance::{self, ImportanceEstimate, ImportanceSettings};
use crate::inference::metropolis::{self, MetropolisSettings};
use crate::inference::nuts::{self, NutsSettings};
use crate::inference::parts::Parts;
use crate::inference::point_estimate::PointEstimate;
use crate::inference::posterior::Posterior;
use crate::inference::smc::{self, SmcSettings};
use crate::inference::target::Target;
use crate::job::stored::Block;
use crate::job::{self, JobError, Step};

/// A second mode is used as a start if its log posterior is within this of the best.
const MODES_WITHIN: f64 = 10.0;

/// Transitions of a chain of trajectories after which its state may be kept, each time.
const TRANSITIONS: u64 = 10;
/// The same of steps of a walk.
const STEPS: u64 = 100;

/// Runs a chain of so many transitions that keeps its state every so many, from the last one that is there.
fn in_parts<S: Block>(
    kept: &dyn job::Parts,
    transitions: u64,
    every: u64,
    run: impl FnOnce(&mut Parts<'_, S>) -> Result<Chain, SampleError>,
) -> Result<Chain, JobError> {
    let from = (1..transitions.div_ceil(every)).rev().find_map(|part| S::from_bytes(&kept.find(part)?, SAMPLE).ok());
    let mut failure = None;
    let mut keep = |part: u64, state: S| match state.into_bytes() {
        Ok(bytes) => kept.keep(part, &bytes),
        Err(error) => failure = Some(error),
    };
    let chain = run(&mut Parts { from, every, is_due: &|| kept.is_due(), keep: &mut keep });
    match failure {
        Some(error) => Err(error),
        None => chain.map_err(|error| JobError::Failed(error.to_string())),
    }
}

impl Calibrate {
    /// Starts of the chains, within the priors' supports.
    fn starts(&self, estimate: &PointEstimate) -> Result<Vec<Vec<f64>>, JobError> {
        let posterior = Posterior::new(&self.target).map_err(|e| JobError::Failed(e.to_string()))?;
        let sd = estimate.sd();
        let best = estimate.descents.iter().filter_map(|d| d.log_posterior).fold(f64::NEG_INFINITY, f64::max);
        let mut modes = vec![estimate.parameters.clone()];
        for descent in &estimate.descents {
            let (Some(end), Some(value)) = (&descent.end, descent.log_posterior) else { continue };
            let apart = |mode: &Vec<f64>| {
                (0..end.len()).any(|i| (end[i] - mode[i]).abs() > 5.0 * sd[i].max(1e-6 * mode[i].abs()))
            };
            if descent.converged && value > best - MODES_WITHIN && modes.iter().all(apart) {
                modes.push(end.clone());
            }
        }
        let key = self.stream("calibrate starts");
        let starts = (0..self.spec.chains).map(|chain| {
            let mut stream = key.stream(chain);
            let mode = &modes[usize::try_from(chain).unwrap_or(0) % modes.len()];
            let moved: Vec<f64> = (0..mode.len())
                .map(|i| {
                    let (lower, upper) = self.target.priors()[i].support();
                    let value = mode[i] + 1.5 * sd[i] * stream.normal();
                    if value > lower && value < upper { value } else { mode[i] }
                })
                .collect();
            posterior.inner_parameters(&moved)
        });
        Ok(starts.collect())
    }

    /// The blocks of sampling.
    pub(super) fn after_estimate(&self, estimate: Box<PointEstimate>) -> Result<Step<Self>, JobError> {
        let mut tasks = Vec::new();
        match self.spec.sampler {
            Sampler::Smc => tasks.extend((0..self.spec.chains).map(|index| Task::Island { index })),
            Sampler::Nuts | Sampler::AdaptiveMetropolis => {
                let starts = self.starts(&estimate)?;
                tasks.extend((0..).zip(starts).map(|(index, start)| Task::Chain { index, start }));
                tasks.push(Task::Evidence);
            }
        }
        Ok(Step::Blocks { stage: SAMPLE.to_owned(), state: State::Sample(estimate), inputs: tasks })
    }

    /// Runs a chain, an island or the evidence.
    pub(super) fn sample(
        &self,
        estimate: &PointEstimate,
        task: Task,
        parts: &dyn job::Parts,
    ) -> Result<Partial, JobError> {
        let failed = |e: SampleError| JobError::Failed(e.to_string());
        let mut target = self.target.clone();
        let reference = target.parameters(&estimate.parameters);
        target.target_mut().set_reference(&reference);
        let (warm_up, draws) = (self.spec.warmup, self.spec.draws);
        match task {
            Task::Chain { index, start } => match self.spec.sampler {
                Sampler::AdaptiveMetropolis => {
                    let settings = MetropolisSettings { warm_up, draws, ..MetropolisSettings::default() };
                    in_parts(parts, warm_up + draws * settings.thin, STEPS, |parts| {
                        metropolis::sample_in_parts(&target, &settings, &self.key, index, Some(&start), parts)
                    })
                }
                Sampler::Nuts | Sampler::Smc => {
                    let normal = Some(estimate.normal_approximation());
                    let mut settings = NutsSettings { warm_up, draws, normal, ..NutsSettings::default() };
                    settings.acceptance = self.spec.acceptance.unwrap_or(settings.acceptance);
                    in_parts(parts, warm_up + draws, TRANSITIONS, |parts| {
                        nuts::sample_in_parts(&target, &settings, &self.key, index, Some(&start), parts)
                    })
                }
            }
            .map(Partial::Chain),
            Task::Island { index } => {
                let particles = usize::try_from(draws).unwrap_or(usize::MAX);
                let settings = SmcSettings { particles, islands: self.spec.chains, ..SmcSettings::default() };
                let island = smc::run_island(&target, &settings, &self.key, index).map_err(failed)?;
                Ok(Partial::Island(Box::new(island)))
            }
            Task::Evidence => {
                let settings = ImportanceSettings::default();
                let key = self.stream("calibrate evidence");
                let found = importance::estimate(&target, &settings, &key, 0, Some(&estimate.parameters));
                let usable = |found: &ImportanceEstimate| {
                    let numbers = [found.log_evidence, found.log_evidence_error, found.effective];
                    (numbers.iter().chain(&found.mean).chain(&found.sd)).all(|number| number.is_finite())
                };
                Ok(Partial::Evidence(found.ok().filter(usable)))
            }
            Task::Estimate | Task::Predict { .. } => Err(JobError::Failed("a block samples nothing".to_owned())),
        }
    }
}
