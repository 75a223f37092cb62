//! The propagation as a job of one stage.

use super::{
    AddedDiscrepancy, Adjustment, BlockInput, BlockOutput, Case, CaseInputs, Discrepancy, FailedSample, Met, Output,
    Reached, Sampling, Spec, reached, summary,
};
use crate::study::variable::Variable;
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};

use crate::math::special::normal_quantile;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::statistics::clusters::Clusters;
use crate::thermal::{External, LANES, Model, Network, SampleBatch, Start};

use crate::job::fault::listed;
use crate::job::{ByCase, Done, Job, JobError, Parts, Step};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::requirement::Environment;

/// Most samples in a block; part of the job's identity.
pub(super) const BLOCK: u64 = 8192;
/// Fewest, and unknown temperatures in all samples of a block: a large network gives every thread work.
const SMALLEST_BLOCK: u64 = 64;
const BLOCK_TEMPERATURES: u64 = 1 << 17;
/// The same where the model is asked outside, which takes its time: what a kill costs at most.
const EXTERNAL_BLOCK: u64 = 16;
/// Batches whose points are drawn at once.
pub(super) const BATCHES_DRAWN: usize = 32;
/// Failed samples kept with their inputs, a block and a case.
pub(super) const FAILURES_KEPT: usize = 20;
/// Name of the only stage.
pub(super) const STAGE: &str = "samples";

/// A propagation, ready to run.
#[derive(Debug)]
pub struct Propagate {
    pub(super) spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) priors: Vec<Distribution>,
    pub(super) network: Network,
    pub(super) points: Points,
    /// Parameters that are not fixed, in order: one coordinate of the points each.
    pub(super) uncertain: Vec<usize>,
    /// Where every solve starts, by case, so that no result depends on the order of samples.
    pub(super) starts: Vec<Vec<f64>>,
    /// Quantities of the nominal parameters, by case.
    nominal: OnceLock<Result<ByCase, JobError>>,
    pub(super) posterior_priors: Vec<PosteriorPrior>,
    /// What is added to quantities, and a coordinate each of points of their own, which pick the errors.
    pub(super) discrepancy: Option<(Vec<Discrepancy>, Points)>,
    /// What is added by the draw of a posterior, that posterior's place in the list, and two coordinates each of points of
    /// their own.
    pub(super) adjustments: Option<(Vec<Adjustment>, usize, Points)>,
}

impl Propagate {
    /// Prepares the job: compiles the network, lays out the points and solves the nominal cases.
    ///
    /// `priors` has one entry a parameter of the model; `name` is the job's name, which its random stream is keyed by.
    ///
    /// # Errors
    /// A network that cannot be compiled or has no steady state, settings that fit no point set.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        priors: Vec<Distribution>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let network = Network::compile(&model, &[]).map_err(|e| failed(e.to_string()))?;
        let uncertain: Vec<usize> = (0..priors.len()).filter(|&i| !priors[i].is_fixed()).collect();
        if uncertain.is_empty() {
            return Err(failed("every parameter is fixed: give at least one a prior to propagate".to_owned()));
        }
        let set = match spec.sampling {
            Sampling::MonteCarlo => PointKind::MonteCarlo,
            Sampling::LatinHypercube => PointKind::LatinHypercube,
            Sampling::Sobol => PointKind::Sobol,
        };
        let key = StreamKey::new(seed, name, "propagate");
        let points = Points::new(set, key, usize::try_from(spec.samples).unwrap_or(usize::MAX), uncertain.len())
            .map_err(|e| failed(e.to_string()))?;
        let mut job = Self {
            spec,
            model,
            priors,
            network,
            points,
            uncertain,
            starts: Vec::new(),
            nominal: OnceLock::new(),
            posterior_priors: Vec::new(),
            discrepancy: None,
            adjustments: None,
        };
        if job.network.external().is_some() {
            // What is asked outside is asked when the job runs; there is nothing to start from.
            job.starts = vec![Vec::new(); job.cases()];
            return Ok(job);
        }
        let (starts, nominal) = job.nominal_cases()?;
        job.starts = starts;
        job.nominal = OnceLock::from(Ok(nominal));
        Ok(job)
    }

    /// The solutions at nominal parameters: temperatures and quantities, by case.
    fn nominal_cases(&self) -> Result<(ByCase, ByCase), JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let (mut starts, mut nominal) = (Vec::new(), Vec::new());
        let mut workspace = self.network.workspace();
        for case in 0..self.cases() {
            let (parameters, inputs) = self.nominal_case(case);
            self.network.set_parameters(&mut workspace, &parameters);
            self.network.set_inputs(&mut workspace, &inputs);
            self.network.solve_steady(&mut workspace, Start::Default).map_err(|e| {
                failed(format!("environment `{}` at nominal parameters: {e}", self.environment(case).name))
            })?;
            starts.push(workspace.temperatures().to_vec());
            let values: Vec<f64> = self.spec.quantities.iter().map(|&q| self.network.quantity(&workspace, q)).collect();
            let quantities = self.spec.quantities.iter().map(|&q| &self.model.quantities[q]);
            if let Some(fault) = quantities.zip(&values).find_map(|(quantity, &value)| quantity.fault(value)) {
                return Err(failed(format!(
                    "{fault} in environment `{}` at nominal parameters: {}",
                    self.environment(case).name,
                    listed(&self.named(parameters))
                )));
            }
            nominal.push(values);
        }
        Ok((starts, nominal))
    }

    /// Quantities of the nominal parameters, by case.
    fn nominal(&self) -> Result<&[Vec<f64>], JobError> {
        match self.nominal.get_or_init(|| Ok(self.nominal_cases()?.1)) {
            Ok(nominal) => Ok(nominal),
            Err(error) => Err(error.clone()),
        }
    }

    /// Samples in a block; part of the job's identity.
    fn block_samples(&self) -> u64 {
        if self.network.external().is_some_and(|own| !own.is_surrogate()) {
            return EXTERNAL_BLOCK;
        }
        let unknowns = (self.network.unknowns() as u64).max(1).next_power_of_two();
        (BLOCK_TEMPERATURES / unknowns).clamp(SMALLEST_BLOCK, BLOCK)
    }

    /// The same with draws in place of the priors of some parameters; posteriors without draws yet may stand among them, for
    /// the job's identity.
    pub fn with_posterior_priors(self, posterior_priors: Vec<PosteriorPrior>) -> Self {
        Self { posterior_priors, ..self }
    }

    /// The same with an error of the model added to quantities: normal, independent from quantity to quantity and of the
    /// parameters, the same in all cases of a sample. Its points are independent draws, since a second Sobol sequence would
    /// not be independent of the first. `seed` and `name` as in [`Propagate::new`].
    ///
    /// # Errors
    /// Settings that fit no point set.
    pub fn with_discrepancy(self, discrepancy: Vec<Discrepancy>, seed: u64, name: &str) -> Result<Self, JobError> {
        if discrepancy.is_empty() {
            return Ok(self);
        }
        let samples = usize::try_from(self.spec.samples).unwrap_or(usize::MAX);
        let key = StreamKey::new(seed, name, "discrepancy");
        let points = Points::new(PointKind::MonteCarlo, key, samples, discrepancy.len())
            .map_err(|error| JobError::Failed(error.to_string()))?;
        Ok(Self { discrepancy: Some((discrepancy, points)), ..self })
    }

    /// The same with discrepancies added to quantities, each as it belongs to the sample's draw of the posterior at this place
    /// of the list; normal about their means, independent of one another, the same deviate in all cases of a sample.
    ///
    /// # Errors
    /// Settings that fit no point set.
    pub fn with_adjustments(
        self,
        adjustments: Vec<Adjustment>,
        posterior: usize,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        if adjustments.is_empty() {
            return Ok(self);
        }
        let samples = usize::try_from(self.spec.samples).unwrap_or(usize::MAX);
        let key = StreamKey::new(seed, name, "discrepancy law");
        let points = Points::new(PointKind::MonteCarlo, key, samples, 2 * adjustments.len())
            .map_err(|error| JobError::Failed(error.to_string()))?;
        Ok(Self { adjustments: Some((adjustments, posterior, points)), ..self })
    }

    /// Name of a quantity, by its position among those asked for.
    pub fn quantity_name(&self, position: usize) -> String {
        self.model.quantities[self.spec.quantities[position]].name.clone()
    }

    /// Name of the environment, design value and inputs (SI, by name) of each case.
    pub fn described(&self) -> Vec<CaseInputs> {
        let of = |case: usize| {
            let (environment, design_value) = self.case_name(case);
            let (_, inputs) = self.nominal_case(case);
            let inputs = self.model.inputs.iter().map(|input| input.name.clone()).zip(inputs).collect();
            CaseInputs { environment, design_value, inputs }
        };
        (0..self.cases()).map(of).collect()
    }

    /// Adds the discrepancies to the values of a block.
    fn add_adjustments(&self, block: BlockInput, first: usize, count: usize, values: &mut [f64]) {
        let Some((adjustments, posterior, points)) = &self.adjustments else { return };
        let posterior_prior = self.posterior_priors.get(*posterior);
        let leader = posterior_prior.and_then(|own| Some((own, self.leader(own)?)));
        let (width, own_width) = (self.uncertain.len(), 2 * adjustments.len());
        let (mut row, mut own) = (vec![0.5; width], vec![0.5; own_width]);
        for sample in 0..count {
            self.points.fill_row(first + sample, &mut row);
            points.fill_row(first + sample, &mut own);
            let draw = leader.map_or(0, |(posterior_prior, leader)| posterior_prior.position(row[leader]));
            for (adjustment, coordinates) in adjustments.iter().zip(own.chunks_exact(2)) {
                let laws = &adjustment.cases[block.case];
                let any = ((coordinates[0] * laws.len() as f64) as usize).min(laws.len().saturating_sub(1));
                let picked = if adjustment.is_paired { draw } else { any };
                let Some((mean, slopes, sd)) = laws.get(picked) else { continue };
                let deviations = adjustment.deviations.get(draw).map_or(&[][..], Vec::as_slice);
                let along = deviations.iter().zip(slopes).map(|(deviation, slope)| deviation * slope).sum::<f64>();
                let added = mean + along + sd * normal_quantile(coordinates[1]);
                for &position in &adjustment.positions {
                    values[position * count + sample] += added;
                }
            }
        }
    }

    /// Adds the model's errors to the values of a block (`quantities x count`).
    pub(super) fn add_discrepancy(&self, first: usize, count: usize, values: &mut [f64]) {
        let Some((discrepancy, points)) = &self.discrepancy else { return };
        let width = discrepancy.len();
        let mut rows = vec![0.5; width * count];
        points.fill_rows(first, &mut rows);
        for (column, quantity_error) in discrepancy.iter().enumerate() {
            for position in
                (0..self.spec.quantities.len()).filter(|&p| self.spec.quantities[p] == quantity_error.quantity)
            {
                let values = &mut values[position * count..(position + 1) * count];
                for (value, row) in values.iter_mut().zip(rows.chunks_exact(width)) {
                    *value += quantity_error.sd * normal_quantile(row[column]);
                }
            }
        }
    }

    /// Coordinate of the points that picks the draw of a posterior; `None` where all its parameters are fixed.
    pub(super) fn leader(&self, own: &PosteriorPrior) -> Option<usize> {
        self.uncertain.iter().position(|parameter| own.parameters.contains(parameter))
    }

    pub(super) fn has_posterior_prior(&self, parameter: usize) -> bool {
        self.posterior_priors.iter().any(|posterior_prior| posterior_prior.parameters.contains(&parameter))
    }

    /// The samples by the draws that they were computed from, for each posterior.
    pub(super) fn clusters(&self) -> Vec<Clusters> {
        let samples = usize::try_from(self.spec.samples).unwrap_or(usize::MAX);
        let width = self.uncertain.len();
        let mut clusters: Vec<Clusters> = (self.posterior_priors.iter())
            .map(|posterior_prior| Clusters {
                of: Vec::with_capacity(samples),
                count: posterior_prior.draws.len(),
                effective: posterior_prior.effective,
            })
            .collect();
        let mut rows = vec![0.5; width * LANES * BATCHES_DRAWN];
        for first in (0..samples).step_by(LANES * BATCHES_DRAWN) {
            let count = (LANES * BATCHES_DRAWN).min(samples - first);
            self.points.fill_rows(first, &mut rows[..width * count]);
            for (posterior_prior, clusters) in self.posterior_priors.iter().zip(&mut clusters) {
                let leader = self.leader(posterior_prior).unwrap_or(0);
                clusters
                    .of
                    .extend(rows[..width * count].chunks_exact(width).map(|row| posterior_prior.position(row[leader])));
            }
        }
        clusters
    }

    /// Number of cases: for each environment the nominal design value, then the sweep.
    pub(super) fn cases(&self) -> usize {
        self.spec.environments.len() * self.designs()
    }

    pub(super) fn designs(&self) -> usize {
        1 + self.spec.sweep.as_ref().map_or(0, |sweep| sweep.values.len())
    }

    pub(super) fn environment(&self, case: usize) -> &Environment {
        &self.spec.environments[case / self.designs()]
    }

    /// The design variable and its value in a case; `None` for the nominal design.
    pub(super) fn design(&self, case: usize) -> Option<(Variable, f64)> {
        let position = (case % self.designs()).checked_sub(1)?;
        let sweep = self.spec.sweep.as_ref()?;
        Some((sweep.variable, sweep.values[position]))
    }

    /// Nominal parameters and the inputs of a case, with its design value in place.
    pub(super) fn nominal_case(&self, case: usize) -> (Vec<f64>, Vec<f64>) {
        let mut parameters: Vec<f64> = self.model.parameters.iter().map(|p| p.nominal).collect();
        for (value, prior) in parameters.iter_mut().zip(&self.priors) {
            if let Distribution::Fixed(fixed) = prior {
                *value = *fixed;
            }
        }
        let mut inputs = self.environment(case).inputs.clone();
        match self.design(case) {
            Some((Variable::Parameter(index), value)) => parameters[index] = value,
            Some((Variable::Input(index), value)) => inputs[index] = value,
            None => {}
        }
        (parameters, inputs)
    }

    /// Runs the samples of a block.
    pub(super) fn run(&self, block: BlockInput) -> BlockOutput {
        let quantities = self.spec.quantities.len();
        let count = usize::try_from(block.count).unwrap_or(usize::MAX);
        let first = usize::try_from(block.first).unwrap_or(usize::MAX);
        let mut output = BlockOutput { values: vec![f64::NAN; quantities * count], failures: Vec::new(), failed: 0 };
        let (nominal, inputs) = self.nominal_case(block.case);
        let swept = match self.design(block.case) {
            Some((Variable::Parameter(index), _)) => Some(index),
            _ => None,
        };
        let start = Start::Temperatures(&self.starts[block.case]);
        let mut batch: SampleBatch = self.network.sample_batch();
        for lane in 0..LANES {
            batch.set_parameters(&self.network, lane, &nominal);
            batch.set_inputs(&self.network, lane, &inputs);
        }
        let width = self.uncertain.len();
        // Lanes beyond the last sample keep a middle value and are not read.
        let mut rows = vec![0.5; width * LANES * BATCHES_DRAWN];
        let (mut done, mut drawn) = (0, 0);
        while done < count {
            let lanes = LANES.min(count - done);
            if done == drawn {
                drawn = count.min(done + LANES * BATCHES_DRAWN);
                self.points.fill_rows(first + done, &mut rows[..width * (drawn - done)]);
            }
            let row = done % (LANES * BATCHES_DRAWN);
            for (position, &parameter) in self.uncertain.iter().enumerate() {
                if swept != Some(parameter) && !self.has_posterior_prior(parameter) {
                    let mut values: [f64; LANES] = std::array::from_fn(|lane| rows[(row + lane) * width + position]);
                    self.priors[parameter].quantiles(&mut values);
                    batch.set_parameter_lanes(parameter, values);
                }
            }
            for (posterior_prior, leader) in self
                .posterior_priors
                .iter()
                .filter_map(|posterior_prior| Some((posterior_prior, self.leader(posterior_prior)?)))
            {
                let draws: [&[f64]; LANES] = std::array::from_fn(|lane| {
                    posterior_prior.draws[posterior_prior.position(rows[(row + lane) * width + leader])].as_slice()
                });
                for (column, &parameter) in posterior_prior.parameters.iter().enumerate() {
                    if swept != Some(parameter) {
                        batch.set_parameter_lanes(parameter, draws.map(|draw| draw[column]));
                    }
                }
            }
            if self.network.external().is_some() {
                batch.use_lanes(lanes);
            }
            self.network.solve_samples(&mut batch, start);
            for lane in 0..lanes {
                let fault = match batch.outcome(lane) {
                    Err(error) => Some(error.to_string()),
                    Ok(_) => self.spec.quantities.iter().find_map(|&quantity| {
                        self.model.quantities[quantity].fault(batch.quantity(&self.network, lane, quantity))
                    }),
                };
                if let Some(reason) = fault {
                    output.failed += 1;
                    if output.failures.len() < FAILURES_KEPT {
                        let index = block.first + (done + lane) as u64;
                        let parameters = self.sample(block.case, index);
                        output.failures.push(FailedSample { index, parameters, reason });
                    }
                    continue;
                }
                for (position, &quantity) in self.spec.quantities.iter().enumerate() {
                    output.values[position * count + done + lane] = batch.quantity(&self.network, lane, quantity);
                }
            }
            done += lanes;
        }
        self.add_discrepancy(first, count, &mut output.values);
        self.add_adjustments(block, first, count, &mut output.values);
        output
    }

    /// The parameters of one sample, by name.
    pub(super) fn sample(&self, case: usize, index: u64) -> Vec<(String, f64)> {
        let (mut parameters, _) = self.nominal_case(case);
        let mut row = vec![0.5; self.uncertain.len()];
        self.points.fill_row(index as usize, &mut row);
        let swept = self.design(case).map(|(variable, _)| variable);
        for (&parameter, &u) in self.uncertain.iter().zip(&row) {
            if swept != Some(Variable::Parameter(parameter)) {
                parameters[parameter] = self.priors[parameter].quantile(u);
            }
        }
        for (posterior_prior, leader) in self
            .posterior_priors
            .iter()
            .filter_map(|posterior_prior| Some((posterior_prior, self.leader(posterior_prior)?)))
        {
            let draw = &posterior_prior.draws[posterior_prior.position(row[leader])];
            for (&parameter, &value) in posterior_prior.parameters.iter().zip(draw) {
                if swept != Some(Variable::Parameter(parameter)) {
                    parameters[parameter] = value;
                }
            }
        }
        self.named(parameters)
    }

    /// All parameters by name.
    pub(super) fn named(&self, parameters: Vec<f64>) -> Vec<(String, f64)> {
        self.model.parameters.iter().map(|p| p.name.clone()).zip(parameters).collect()
    }
}

impl Job for Propagate {
    type State = ();
    type Input = BlockInput;
    type Partial = BlockOutput;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "propagate"
    }

    fn algorithm_version(&self) -> u32 {
        4
    }

    fn identity(&self) -> Value {
        let mut identity = json!({
            "settings": self.spec,
            "block": self.block_samples(),
            "model": self.model.identity(),
            "priors": self.priors,
        });
        if !self.posterior_priors.is_empty() {
            identity["posterior_priors"] = self.posterior_priors.iter().map(PosteriorPrior::identity).collect();
        }
        if let Some((discrepancy, _)) = &self.discrepancy {
            identity["discrepancy"] = json!(discrepancy);
        }
        identity
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        if let Some(posterior_prior) =
            self.posterior_priors.iter().find(|posterior_prior| posterior_prior.draws.is_empty())
        {
            return Err(JobError::Failed(format!("the posterior of {} has no draws", posterior_prior.source)));
        }
        // A model that cannot be had at its nominal parameters is not asked for samples.
        self.nominal()?;
        let mut inputs = Vec::new();
        for case in 0..self.cases() {
            let mut first = 0;
            while first < self.spec.samples {
                let count = self.block_samples().min(self.spec.samples - first);
                inputs.push(BlockInput { case, first, count });
                first += count;
            }
        }
        Ok(Step::Blocks { stage: STAGE.to_owned(), state: (), inputs })
    }

    fn block(&self, (): &(), input: BlockInput, _parts: &dyn Parts) -> Result<BlockOutput, JobError> {
        Ok(self.run(input))
    }

    fn memory_bytes(&self) -> u64 {
        // The blocks' values of all cases, the values of one case by quantity, and a sorted copy of one.
        let (quantities, cases) = (self.spec.quantities.len() as u64, self.cases() as u64);
        let columns = quantities.saturating_mul(cases).saturating_add(quantities + 2);
        columns.saturating_mul(self.spec.samples).saturating_mul(size_of::<f64>() as u64)
    }

    fn external(&self) -> Option<&External> {
        self.network.external()
    }

    fn is_last(&self, (): &()) -> bool {
        true
    }

    fn so_far(&self, blocks: Done<Self>) -> Vec<String> {
        self.met_so_far(&blocks)
    }

    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let per_case = usize::try_from(self.spec.samples.div_ceil(self.block_samples())).unwrap_or(usize::MAX);
        let mut cases = Vec::new();
        let clusters = self.clusters();
        let nominal = self.nominal()?;
        let mut blocks = blocks.into_iter().map(|(_, block)| block).peekable();
        let mut case = 0;
        while blocks.peek().is_some() {
            let samples = usize::try_from(self.spec.samples).unwrap_or(usize::MAX);
            let mut values: Vec<Vec<f64>> = vec![Vec::new(); self.spec.quantities.len()];
            values.iter_mut().for_each(|column| column.reserve_exact(samples));
            let mut failures = Vec::new();
            let mut failed = 0;
            for block in blocks.by_ref().take(per_case.max(1)) {
                let count = block.values.len() / values.len().max(1);
                for (position, column) in values.iter_mut().enumerate() {
                    column.extend(&block.values[position * count..(position + 1) * count]);
                }
                failed += block.failed;
                failures.extend(block.failures);
            }
            failures.truncate(FAILURES_KEPT);
            let share = failed as f64 / self.spec.samples.max(1) as f64;
            let is_too_few = failed + 2 > self.spec.samples;
            if share > self.spec.failure_limit || is_too_few {
                // One solution alone has no distribution, whatever the study tolerates.
                let why = if is_too_few {
                    "fewer than two are left".to_owned()
                } else {
                    format!("more than the limit of {} %", 100.0 * self.spec.failure_limit)
                };
                let described =
                    |f: &FailedSample| format!("; sample {}: {} ({})", f.index, f.reason, listed(&f.parameters));
                let example = failures.first().map_or(String::new(), described);
                return Err(JobError::Failed(format!(
                    "{failed} of {} samples failed, {why}{example}",
                    self.spec.samples
                )));
            }
            let mut summary = summary::case(
                &self.spec,
                &self.model,
                self.case_name(case),
                &values,
                &clusters,
                &nominal[case],
                failed,
                failures,
            );
            // Parameters that share draws have no effects of their own.
            if self.design(case).is_none() && self.posterior_priors.is_empty() {
                summary.main_effects = self.main_effects(&values);
            }
            cases.push(summary);
            case += 1;
        }
        let reached = self.reached(&cases);
        let output = Output {
            samples: self.spec.samples,
            sampling: match self.spec.sampling {
                Sampling::MonteCarlo => "monte-carlo",
                Sampling::LatinHypercube => "latin-hypercube",
                Sampling::Sobol => "sobol",
            }
            .to_owned(),
            design_variable: self.spec.sweep.as_ref().map(|sweep| sweep.name.clone()),
            design_unit: self.spec.sweep.as_ref().map(|sweep| sweep.unit.clone()).unwrap_or_default(),
            cases,
            reached,
            posterior_priors: self.posterior_priors.iter().map(PosteriorPrior::summary).collect(),
            discrepancy: self.added(),
            converged: (!self.posterior_priors.is_empty())
                .then(|| self.posterior_priors.iter().all(|posterior_prior| posterior_prior.converged)),
        };
        Ok(Step::Done(Box::new(output)))
    }
}

impl Propagate {
    /// The model's errors by name.
    pub(super) fn added(&self) -> Vec<AddedDiscrepancy> {
        let model_errors = self.discrepancy.iter().flat_map(|(discrepancy, _)| discrepancy);
        let named = model_errors.map(|model_error| {
            let quantity = &self.model.quantities[model_error.quantity];
            AddedDiscrepancy { quantity: quantity.name.clone(), sd: model_error.sd, unit: quantity.unit.clone() }
        });
        named.collect()
    }

    pub(super) fn case_name(&self, case: usize) -> (String, Option<f64>) {
        (self.environment(case).name.clone(), self.design(case).map(|(_, value)| value))
    }

    /// Where each requirement reaches its probability, by environment.
    pub(super) fn reached(&self, cases: &[Case]) -> Vec<Reached> {
        let mut reached_values = Vec::new();
        if self.spec.sweep.is_none() {
            return reached_values;
        }
        for environment in cases.chunks(self.designs()) {
            let swept = &environment[1..];
            let outcomes = swept.first().map_or(0, |case| case.requirements.len());
            for position in 0..outcomes {
                let points: Vec<(f64, &Met)> =
                    swept.iter().filter_map(|case| case.design_value.zip(case.requirements.get(position))).collect();
                reached_values.extend(reached::reached(&environment[0].environment, &points, self.spec.samples));
            }
        }
        reached_values
    }
}
