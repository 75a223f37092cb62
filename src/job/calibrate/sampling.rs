//! Where chains start, and what runs them: chains, islands of particles, the evidence.

use super::Calibrate;
use super::block::{Partial, State, Task};
use super::run::SAMPLE;
use super::sampler::Run;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::posterior::Posterior;
use crate::inference::sampler::importance::{self, ImportanceEstimate, ImportanceSettings};
use crate::inference::target::Target;
use crate::job::{self, JobError, Step};
use crate::measurement::{Measurement, Rows};
use crate::thermal::{Node, NodeKind};

/// A second mode is used as a start if its log posterior is within this of the best.
const MODES_WITHIN: f64 = 10.0;

/// Unknown temperatures, and rows of transients, from which on the draws of the evidence end early.
const LARGE: usize = 200;
const LONG: usize = 1000;
/// The standard error of a log evidence that is then good enough: a factor of 1.05.
const ENOUGH: f64 = 0.05;

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
        if self.spec.sampler.method().has_islands() {
            tasks.extend((0..self.spec.chains).map(|index| Task::Island { index }));
        } else {
            let starts = self.starts(&estimate)?;
            tasks.extend((0..).zip(starts).map(|(index, start)| Task::Chain { index, start }));
            tasks.push(Task::Evidence);
        }
        Ok(Step::Blocks { stage: SAMPLE.to_owned(), state: State::Sample(estimate), inputs: tasks })
    }

    /// Standard error of the log evidence at which its draws may end; 0 where they are cheap enough to make all.
    pub(super) fn evidence_error(&self) -> f64 {
        let is_unknown = |node: &&Node| !matches!(node.kind, NodeKind::Boundary { .. });
        let transients = self.measurements().into_iter().filter(|m| matches!(m.rows, Rows::Transient { .. }));
        let is_long = transients.map(Measurement::len).sum::<usize>() >= LONG;
        let is_large = self.inputs.model.nodes.iter().filter(is_unknown).count() >= LARGE;
        if is_large || is_long { ENOUGH } else { 0.0 }
    }

    /// Runs a chain, an island or the evidence.
    pub(super) fn sample(
        &self,
        estimate: &PointEstimate,
        task: Task,
        parts: &dyn job::Parts,
    ) -> Result<Partial, JobError> {
        let mut target = self.target.clone();
        let reference = target.parameters(&estimate.parameters);
        target.target_mut().set_reference(&reference);
        let method = self.spec.sampler.method();
        let run = |index, start| Run { calibration: self, target: &target, estimate, index, start, parts };
        match task {
            Task::Chain { index, start } => method.run(&run(index, Some(&start))),
            Task::Island { index } => method.run(&run(index, None)),
            Task::Evidence => {
                let settings = ImportanceSettings { wanted_error: self.evidence_error(), ..Default::default() };
                let key = self.stream("calibrate evidence");
                let evidence = importance::estimate(&target, &settings, &key, 0, Some(&estimate.parameters));
                let usable = |candidate: &ImportanceEstimate| {
                    let numbers = [candidate.log_evidence, candidate.log_evidence_error, candidate.effective];
                    (numbers.iter().chain(&candidate.mean).chain(&candidate.sd)).all(|number| number.is_finite())
                };
                Ok(Partial::Evidence(evidence.ok().filter(usable)))
            }
            Task::Estimate | Task::Predict { .. } => Err(JobError::Failed("a block samples nothing".to_owned())),
        }
    }
}
