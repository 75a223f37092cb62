//! The sensitivity analysis as a job: what it is asked, and its stages.

use super::{FailedSolve, Method, Output, Spec, block};
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};

use crate::expression::Symbol;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::thermal::{External, Model, Network, Start};

use super::block::{BlockInput, Found, Work};
use crate::job::fault::listed;
use crate::job::{ByCase, Done, Job, JobError, Parts, Step};

/// Solves of a block of rows, about; part of the identity.
pub(super) const BLOCK_SOLVES: u64 = 1 << 15;
/// The same, solves and trajectories, where the model is asked outside, which takes its time: what a kill costs at most.
const EXTERNAL_BLOCK: (u64, u64) = (128, 8);
/// Rows of the first stage where a precision is asked for; each further stage doubles the rows.
pub(super) const FIRST_ROWS: u64 = 1024;
/// Points of a scramble at which derivatives are squared.
pub(super) const DERIVATIVE_POINTS: u64 = 256;
/// Trajectories of a block; part of the identity.
pub(super) const BLOCK_TRAJECTORIES: u64 = 64;

/// A sensitivity analysis, ready to run.
#[derive(Debug)]
pub struct Sensitivity {
    pub(super) spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) priors: Vec<Distribution>,
    pub(super) network: Network,
    /// The network with derivatives by the uncertain parameters.
    pub(super) differentiated: Network,
    /// Parameters that are not fixed, in order.
    pub(super) uncertain: Vec<usize>,
    /// Point sets of twice as many dimensions as uncertain parameters, a scramble each.
    pub(super) points: Vec<Points>,
    pub(super) trajectory_key: StreamKey,
    /// Nominal parameters, fixed ones at their known value.
    pub(super) nominal: Vec<f64>,
    /// Where every solve starts, by environment.
    pub(super) starts: Vec<Vec<f64>>,
    /// Quantities at the nominal parameters, by environment.
    centres: OnceLock<Result<ByCase, JobError>>,
}

impl Sensitivity {
    /// Prepares the job: compiles the network, lays out the points and solves the nominal cases.
    ///
    /// `priors` has one entry a parameter of the model; `name` is the job's name, which its random streams are keyed by.
    ///
    /// # Errors
    /// A network that cannot be compiled or has no steady state, no uncertain parameter, or more of them than a Sobol sequence has
    /// dimensions for.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        priors: Vec<Distribution>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let uncertain: Vec<usize> = (0..priors.len()).filter(|&i| !priors[i].is_fixed()).collect();
        if uncertain.is_empty() {
            return Err(failed("every parameter is fixed: give at least one a prior to see what it does".to_owned()));
        }
        let network = Network::compile(&model, &[]).map_err(|e| failed(e.to_string()))?;
        let symbols: Vec<Symbol> =
            uncertain.iter().map(|&i| Symbol::Parameter(u32::try_from(i).unwrap_or(u32::MAX))).collect();
        let differentiated = Network::compile(&model, &symbols).map_err(|e| failed(e.to_string()))?;
        let points: Result<Vec<Points>, _> = (0..spec.scrambles)
            .map(|scramble| {
                let key = StreamKey::new(seed, name, &format!("sensitivity {scramble}"));
                let samples = usize::try_from(spec.samples).unwrap_or(usize::MAX);
                Points::new(PointKind::Sobol, key, samples, 2 * uncertain.len())
            })
            .collect();
        let points = points.map_err(|e| failed(format!("{} uncertain parameters: {e}", uncertain.len())))?;
        let nominal: Vec<f64> = model
            .parameters
            .iter()
            .zip(&priors)
            .map(|(parameter, prior)| if let Distribution::Fixed(value) = prior { *value } else { parameter.nominal })
            .collect();
        let trajectory_key = StreamKey::new(seed, name, "trajectories");
        let mut job = Self {
            spec,
            model,
            priors,
            network,
            differentiated,
            uncertain,
            points,
            trajectory_key,
            nominal,
            starts: Vec::new(),
            centres: OnceLock::new(),
        };
        if job.network.external().is_some() {
            // What is asked outside is asked when the job runs; there is nothing to start from.
            job.starts = vec![Vec::new(); job.spec.environments.len()];
            return Ok(job);
        }
        let (starts, centres) = job.nominal_cases()?;
        job.starts = starts;
        job.centres = OnceLock::from(Ok(centres));
        Ok(job)
    }

    /// The solutions at nominal parameters: temperatures and quantities, by environment.
    fn nominal_cases(&self) -> Result<(ByCase, ByCase), JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let (mut starts, mut all_centres) = (Vec::new(), Vec::new());
        let mut workspace = self.network.workspace();
        self.network.set_parameters(&mut workspace, &self.nominal);
        for environment in &self.spec.environments {
            self.network.set_inputs(&mut workspace, &environment.inputs);
            self.network
                .solve_steady(&mut workspace, Start::Default)
                .map_err(|e| failed(format!("environment `{}` at nominal parameters: {e}", environment.name)))?;
            let centres: Vec<f64> =
                self.spec.quantities.iter().map(|&q| self.network.quantity(&workspace, q)).collect();
            let quantities = self.spec.quantities.iter().map(|&q| &self.model.quantities[q]);
            if let Some(fault) = quantities.zip(&centres).find_map(|(quantity, &value)| quantity.fault(value)) {
                let nominal_values: Vec<f64> = self.uncertain.iter().map(|&index| self.nominal[index]).collect();
                return Err(failed(format!(
                    "{fault} in environment `{}` at nominal parameters: {}",
                    environment.name,
                    listed(&self.named(&nominal_values))
                )));
            }
            starts.push(workspace.temperatures().to_vec());
            all_centres.push(centres);
        }
        Ok((starts, all_centres))
    }

    /// Quantities at the nominal parameters, by environment.
    pub(super) fn centres(&self) -> Result<&[Vec<f64>], JobError> {
        match self.centres.get_or_init(|| Ok(self.nominal_cases()?.1)) {
            Ok(centres) => Ok(centres),
            Err(error) => Err(error.clone()),
        }
    }

    /// Solves of a block of rows, about, and trajectories of a block; part of the identity.
    fn block_sizes(&self) -> (u64, u64) {
        let is_slow = self.network.external().is_some_and(|own| !own.is_surrogate());
        if is_slow { EXTERNAL_BLOCK } else { (BLOCK_SOLVES, BLOCK_TRAJECTORIES) }
    }

    /// The uncertain parameters by name.
    pub(super) fn named(&self, values: &[f64]) -> Vec<(String, f64)> {
        self.uncertain
            .iter()
            .map(|&index| self.model.parameters[index].name.clone())
            .zip(values.iter().copied())
            .collect()
    }

    /// Rows of a block.
    pub(super) fn block_rows(&self) -> u64 {
        let rows = (self.block_sizes().0 / self.points_of_row() as u64).max(1);
        // The power of two at or below.
        1 << rows.ilog2()
    }

    /// Blocks of the rows from `from` to `to - 1` of every scramble and environment.
    pub(super) fn row_blocks(&self, from: u64, to: u64) -> Vec<BlockInput> {
        let rows = self.block_rows();
        let mut inputs = Vec::new();
        for case in 0..self.spec.environments.len() {
            for scramble in 0..self.spec.scrambles {
                let mut first = from;
                while first < to {
                    let count = rows.min(to - first);
                    inputs.push(BlockInput { case, work: Work::Sobol { scramble, first, count } });
                    first += count;
                }
            }
        }
        inputs
    }

    /// Rows of a scramble after the first stage.
    pub(super) fn first_rows(&self) -> u64 {
        if self.spec.precision.is_some() { FIRST_ROWS.min(self.spec.samples) } else { self.spec.samples }
    }

    pub(super) fn step(rows: u64, state: Vec<Found>, inputs: Vec<BlockInput>) -> Step<Self> {
        Step::Blocks { stage: format!("rows to {rows}"), state, inputs }
    }

    /// Fails where more solves failed than the study tolerates, or nothing is left.
    pub(super) fn check_failures(&self, found: &[Found]) -> Result<(), JobError> {
        for (case, solved) in found.iter().enumerate() {
            let share = solved.failed as f64 / solved.solves.max(1) as f64;
            let rows = |scramble: &block::OfScramble| scramble.sums.iter().all(|sums| sums.rows() == 0);
            let is_empty = solved.scrambles.iter().any(rows);
            if share > self.spec.failure_limit || is_empty {
                let described = |f: &FailedSolve| format!("; {}: {} ({})", f.place, f.reason, listed(&f.parameters));
                let example = solved.failures.first().map_or(String::new(), described);
                let why = if is_empty {
                    "no row of a scramble is left".to_owned()
                } else {
                    format!("more than the limit of {} %", 100.0 * self.spec.failure_limit)
                };
                return Err(JobError::Failed(format!(
                    "environment `{}`: {} of {} solves failed, {why}{example}",
                    self.spec.environments[case].name, solved.failed, solved.solves
                )));
            }
        }
        Ok(())
    }
}

impl Job for Sensitivity {
    type State = Vec<Found>;
    type Input = BlockInput;
    type Partial = Found;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "sensitivity"
    }

    fn algorithm_version(&self) -> u32 {
        1
    }

    fn identity(&self) -> Value {
        json!({
            "settings": self.spec,
            "block_solves": self.block_sizes().0,
            "model": self.model.identity(),
            "priors": self.priors,
        })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        // A model that cannot be had at its nominal parameters is not asked elsewhere.
        self.centres()?;
        let mut inputs = Vec::new();
        for case in 0..self.spec.environments.len() {
            let mut add = |work: Work| inputs.push(BlockInput { case, work });
            if self.spec.has(Method::Local) {
                add(Work::Local);
            }
            if self.spec.has(Method::Morris) {
                let mut first = 0;
                while first < self.spec.trajectories {
                    let count = self.block_sizes().1.min(self.spec.trajectories - first);
                    add(Work::Morris { first, count });
                    first += count;
                }
            }
            if self.spec.has(Method::Derivative) {
                for scramble in 0..self.spec.scrambles {
                    add(Work::Derivative { scramble, count: DERIVATIVE_POINTS.min(self.spec.samples) });
                }
            }
        }
        let rows = self.first_rows();
        if self.spec.has(Method::Sobol) {
            inputs.extend(self.row_blocks(0, rows));
        }
        let state = vec![Found::default(); self.spec.environments.len()];
        Ok(Self::step(rows, state, inputs))
    }

    fn block(&self, _state: &Vec<Found>, input: BlockInput, _parts: &dyn Parts) -> Result<Found, JobError> {
        Ok(match input.work {
            Work::Local => self.local(input.case)?,
            Work::Morris { first, count } => self.trajectories(input.case, first, count),
            Work::Sobol { scramble, first, count } => self.rows(input.case, scramble, first, count)?,
            Work::Derivative { scramble, count } => self.squares(input.case, scramble, count),
        })
    }

    fn external(&self) -> Option<&External> {
        self.network.external()
    }

    fn is_last(&self, _state: &Vec<Found>) -> bool {
        self.spec.precision.is_none()
    }

    fn reduce(&self, mut found: Vec<Found>, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let mut rows = 0;
        for (input, block) in blocks {
            if let Work::Sobol { first, count, .. } = input.work {
                rows = rows.max(first + count);
            }
            found
                .get_mut(input.case)
                .ok_or_else(|| JobError::Failed("a block is of an environment that does not exist".to_owned()))?
                .absorb(&input.work, block);
        }
        self.check_failures(&found)?;
        if let Some(precision) = self.spec.precision
            && self.spec.has(Method::Sobol)
            && rows < self.spec.samples
            && !(self.widest(&found) <= precision)
        {
            let next = (2 * rows).min(self.spec.samples);
            return Ok(Self::step(next, found, self.row_blocks(rows, next)));
        }
        Ok(Step::Done(Box::new(self.output(&found, rows)?)))
    }
}
