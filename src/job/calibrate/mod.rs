//! Parameters from measurements: the most probable point from several starts, the posterior by chains or islands, the
//! evidence, and predictive checks.
//!
//! Stages: `estimate` (one block), `sample` (a chain, an island or the evidence a block), `predict` (draws of
//! posterior and prior). Chains start round the modes that the estimate found, spread by three halves of Laplace's
//! standard deviations.

mod block;
mod output;
mod predictive;
mod scores;
mod summary;
mod words;

use std::sync::Arc;

use serde_json::{Value, json};

pub use output::{
    Coverage, CrossValidation, Evidence, HandedOnPrior, HeldOutScore, KeptDraws, MostProbable, Output,
    ParameterSummary, PhaseScore, PredictiveRow, Sampler, SensorPredictive, Spec, Spent, UsedData,
};

use super::handed_on::HandedOn;
use super::{Job, JobError, Step};
use crate::expression::Unit;
use crate::inference::chains::{Chain, Chains};
use crate::inference::convergence::{self, Convergence, ConvergenceLimits};
use crate::inference::importance::{self, ImportanceEstimate, ImportanceSettings};
use crate::inference::informed::Informed;
use crate::inference::joint_prior::Fit;
use crate::inference::likelihood::{Definition, InputError, Likelihood};
use crate::inference::measurement::Measurement;
use crate::inference::metropolis::{self, MetropolisSettings};
use crate::inference::nuts::{self, NutsSettings};
use crate::inference::point_estimate::{self, PointEstimate, PointSettings};
use crate::inference::posterior::{Posterior, Work};
use crate::inference::prediction::Predictor;
use crate::inference::psis::{self, LeaveOneOut};
use crate::inference::rows::used_rows;
use crate::inference::smc::{self, Island, SmcSettings};
use crate::inference::target::{LeastSquares, Target};
use crate::inference::unknown::settled;
use crate::math::special::chi_square_sf;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::thermal::Model;
use block::{PredictInput, Predicted, SampleInput, SampleOutput, SampleTask, from_bytes, to_bytes};
use predictive::Draws;
use summary::Weighted;

const ESTIMATE: &str = "estimate";
const SAMPLE: &str = "sample";
const PREDICT: &str = "predict";
/// Draws kept of all chains.
const KEPT: usize = 1000;
/// Draws of the posterior in the predictive checks.
const POSTERIOR_CHECKS: usize = 400;
/// Draws of the prior in the predictive checks; a power of two.
const PRIOR_CHECKS: usize = 256;
/// Draws of a block of predictive checks.
const BLOCK: usize = 50;
/// A second mode is used as a start if its log posterior is within this of the best.
const MODES_WITHIN: f64 = 10.0;
/// Scatter of the islands' log evidence above which their weights are too uneven.
const EVIDENCE_ERROR: f64 = 0.5;

/// What a calibration is made of.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The model.
    pub model: Arc<Model>,
    /// Priors of its parameters, SI.
    pub priors: Vec<Distribution>,
    /// The pass's measurements.
    pub measurements: Arc<Vec<Measurement>>,
    /// Own errors of the inputs.
    pub input_errors: Vec<InputError>,
}

/// A calibration, ready to run.
#[derive(Debug)]
pub struct Calibrate {
    spec: Spec,
    inputs: Inputs,
    /// The likelihood with priors that may be posteriors handed on.
    target: Informed<Likelihood>,
    handed_on: Vec<HandedOn>,
    /// How well a density describes the draws of each posterior handed on.
    fits: Vec<(String, Fit)>,
    predictor: Predictor,
    key: StreamKey,
    name: String,
    seed: u64,
}

impl Calibrate {
    /// Prepares the job; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// What no likelihood can be made of: no reading, no noise, nothing to infer, a network that does not compile.
    pub fn new(spec: Spec, inputs: Inputs, seed: u64, name: &str) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let measurements: Vec<&Measurement> = spec.data.iter().map(|&index| &inputs.measurements[index]).collect();
        let likelihood = Likelihood::new(&Definition {
            model: &inputs.model,
            priors: &inputs.priors,
            parameters: &spec.parameters,
            measurements: &measurements,
            input_errors: &inputs.input_errors,
        })
        .map_err(|e| failed(e.to_string()))?;
        let predictor = Predictor::new(&inputs.model, &[]).map_err(|e| failed(e.to_string()))?;
        let key = StreamKey::new(seed, name, "calibrate");
        let target = Informed::new(likelihood, Vec::new());
        let (handed_on, fits, name) = (Vec::new(), Vec::new(), name.to_owned());
        Ok(Self { spec, inputs, target, handed_on, fits, predictor, key, name, seed })
    }

    /// The same with posteriors in place of the priors of some parameters. Those without draws yet count for the job's
    /// identity alone. Of a posterior of more parameters than are chosen here, the others are averaged over.
    ///
    /// # Errors
    /// Draws that no density describes, with what deviates.
    pub fn with_handed_on(self, handed_on: Vec<HandedOn>) -> Result<Self, JobError> {
        let (mut joint, mut fits) = (Vec::new(), Vec::new());
        for own in handed_on.iter().filter(|own| !own.draws.is_empty()) {
            let density =
                own.density(&self.target.target().unknowns().model, &self.inputs.priors).map_err(|error| {
                    JobError::Failed(format!("the posterior of {} cannot be a prior here: {error}", own.source))
                })?;
            if let Some(density) = density {
                fits.push((own.source.clone(), density.fit().clone()));
                joint.push(density);
            }
        }
        let target = Informed::new(self.target.target().clone(), joint);
        Ok(Self { target, handed_on, fits, ..self })
    }

    fn likelihood(&self) -> &Likelihood {
        self.target.target()
    }

    fn measurements(&self) -> Vec<&Measurement> {
        self.spec.data.iter().map(|&index| &self.inputs.measurements[index]).collect()
    }

    fn stream(&self, purpose: &str) -> StreamKey {
        StreamKey::new(self.seed, &self.name, purpose)
    }

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

    fn after_estimate(&self, estimate: &PointEstimate) -> Result<Step, JobError> {
        let mut tasks = Vec::new();
        match self.spec.sampler {
            Sampler::Smc => tasks.extend((0..self.spec.chains).map(|index| SampleTask::Island { index })),
            Sampler::Nuts | Sampler::AdaptiveMetropolis => {
                let starts = self.starts(estimate)?;
                tasks.extend((0..).zip(starts).map(|(index, start)| SampleTask::Chain { index, start }));
                tasks.push(SampleTask::Evidence);
            }
        }
        let inputs = tasks.into_iter().map(|task| to_bytes(&SampleInput { estimate: estimate.clone(), task }));
        Ok(Step::Blocks { stage: SAMPLE.to_owned(), inputs: inputs.collect::<Result<_, _>>()? })
    }

    fn sample(&self, input: SampleInput) -> Result<SampleOutput, JobError> {
        let failed = |e: crate::inference::chains::SampleError| JobError::Failed(e.to_string());
        let mut target = self.target.clone();
        let reference = target.parameters(&input.estimate.parameters);
        target.target_mut().set_reference(&reference);
        let (warm_up, draws) = (self.spec.warmup, self.spec.draws);
        match input.task {
            SampleTask::Chain { index, start } => match self.spec.sampler {
                Sampler::AdaptiveMetropolis => {
                    let settings = MetropolisSettings { warm_up, draws, ..MetropolisSettings::default() };
                    metropolis::sample(&target, &settings, &self.key, index, Some(&start))
                }
                Sampler::Nuts | Sampler::Smc => {
                    let covariance = Some(input.estimate.covariance.clone());
                    let settings = NutsSettings { warm_up, draws, covariance, ..NutsSettings::default() };
                    nuts::sample(&target, &settings, &self.key, index, Some(&start))
                }
            }
            .map(SampleOutput::Chain)
            .map_err(failed),
            SampleTask::Island { index } => {
                let particles = usize::try_from(draws).unwrap_or(usize::MAX);
                let settings = SmcSettings { particles, islands: self.spec.chains, ..SmcSettings::default() };
                let island = smc::run_island(&target, &settings, &self.key, index).map_err(failed)?;
                Ok(SampleOutput::Island(Box::new(island)))
            }
            SampleTask::Evidence => {
                let settings = ImportanceSettings::default();
                let key = self.stream("calibrate evidence");
                let found = importance::estimate(&target, &settings, &key, 0, Some(&input.estimate.parameters));
                let usable = |found: &ImportanceEstimate| {
                    let numbers = [found.log_evidence, found.log_evidence_error, found.effective];
                    (numbers.iter().chain(&found.mean).chain(&found.sd)).all(|number| number.is_finite())
                };
                Ok(SampleOutput::Evidence(found.ok().filter(usable)))
            }
        }
    }

    fn after_samples(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        let first = inputs.first().ok_or_else(|| JobError::Failed("there are no chains".to_owned()))?;
        let estimate = self.target.estimate(&from_bytes::<SampleInput>(first, stage)?.estimate);
        let (mut chains, mut islands, mut importance) = (Vec::<Chain>::new(), Vec::<Island>::new(), None);
        for bytes in outputs {
            match SampleOutput::from_bytes(bytes, stage)? {
                SampleOutput::Chain(chain) => chains.push(self.target.chain(&chain)),
                SampleOutput::Island(island) => {
                    islands.push(Island { chain: self.target.chain(&island.chain), ..*island });
                }
                SampleOutput::Evidence(found) => importance = found,
            }
        }
        let names = self.likelihood().names().to_vec();
        let mut objections = Vec::new();
        let mut weights = None;
        let mut evidence = Evidence {
            value: estimate.log_evidence,
            sd: None,
            method: "laplace".to_owned(),
            pareto_k: None,
            laplace: estimate.log_evidence,
        };
        let chains = if self.spec.sampler == Sampler::Smc {
            let result = smc::combine(&names, islands);
            if !result.finished {
                objections.push("an island did not reach the posterior within its stages".to_owned());
            }
            let error = result.log_evidence_error;
            if !(error <= EVIDENCE_ERROR) {
                objections.push(format!("the islands' evidences scatter by {error:.2} in the logarithm"));
            }
            evidence.value = Some(result.log_evidence).filter(|value| value.is_finite());
            evidence.sd = Some(error).filter(|value| value.is_finite());
            evidence.method = "smc".to_owned();
            weights = Some(result.weights);
            result.chains
        } else {
            if let Some(found) = &importance {
                evidence.value = Some(found.log_evidence);
                evidence.sd = Some(found.log_evidence_error);
                evidence.method = "importance sampling".to_owned();
                evidence.pareto_k = found.pareto_k;
            }
            Chains { names: names.clone(), chains }
        };
        if chains.is_empty() || chains.chains.iter().any(|chain| chain.len() != chains.chains[0].len()) {
            return Err(JobError::Failed("the chains have no draws, or not equally many".to_owned()));
        }
        let judged = convergence::judge(&chains, self.likelihood().priors(), &ConvergenceLimits::default());
        objections.extend(words::objections(&judged, &names));
        for own in self.handed_on.iter().filter(|own| !own.converged) {
            objections.push(format!("the prior is the posterior of {}, whose chains did not converge", own.source));
        }
        let mut work = chains.work();
        work.merge(&estimate.work);
        if let Some(found) = &importance {
            work.merge(&found.work);
        }
        let output = self.output(&estimate, &chains, weights.as_deref(), &judged, evidence, objections, &work);
        self.predict_blocks(output)
    }

    fn output(
        &self,
        estimate: &PointEstimate,
        chains: &Chains,
        weights: Option<&[f64]>,
        judged: &Convergence,
        log_evidence: Evidence,
        objections: Vec<String>,
        work: &Work,
    ) -> Output {
        let unknowns = self.likelihood().unknowns();
        let weighted = Weighted::new(chains, weights);
        let sd = estimate.sd();
        let parameters = unknowns.names.iter().enumerate().map(|(place, name)| {
            let text = &unknowns.units[place];
            let unit = Unit::parse(text).ok();
            let shown = |value: f64| unit.as_ref().map_or(value, |unit| unit.from_si(value));
            let spread = |value: f64| unit.as_ref().map_or(value, |unit| unit.difference_from_si(value));
            let own = &judged.parameters[place];
            let quantiles = weighted.quantiles(place, &[0.025, 0.5, 0.975]);
            let summary = ParameterSummary {
                unit: text.clone(),
                prior: unknowns.priors[place],
                handed_on: self.handed_on_prior(place, &shown, &spread),
                mean: shown(weighted.mean(place)),
                sd: spread(weighted.covariance(place, place).sqrt()),
                q025: shown(quantiles[0]),
                q50: shown(quantiles[1]),
                q975: shown(quantiles[2]),
                rhat: own.r_hat,
                ess_bulk: own.ess_bulk,
                ess_tail: own.ess_tail,
                mcse_mean: own.mcse_mean.map(spread),
                at_bound: own.share_at_lower.unwrap_or(0.0) + own.share_at_upper.unwrap_or(0.0),
                map: shown(estimate.parameters[place]),
                laplace_sd: spread(sd[place]),
            };
            (name.clone(), summary)
        });
        let log_posterior = estimate.log_likelihood + estimate.log_prior;
        let reached = estimate.descents.iter().filter(|d| d.log_posterior.is_some_and(|p| p > log_posterior - 0.1));
        let data = self.spec.data.iter().enumerate().map(|(place, &index)| UsedData {
            measurement: self.inputs.measurements[index].name.clone(),
            sha256: self.inputs.measurements[index].sha256.clone(),
            readings: self.likelihood().data().iter().filter(|datum| datum.measurement == place).count() as u64,
            rows: used_rows(&self.inputs.measurements[index])
                .iter()
                .map(|row| (row.label.clone(), row.sha256()))
                .collect(),
        });
        Output {
            converged: objections.is_empty(),
            objections,
            sampler: self.spec.sampler.name().to_owned(),
            chains: [chains.chains.len() as u64, chains.chains[0].len() as u64],
            order: unknowns.names.clone(),
            model_parameters: self.likelihood().model_parameters() as u64,
            correlations: weighted.correlations(unknowns.len()),
            most_probable: MostProbable {
                log_likelihood: estimate.log_likelihood,
                log_prior: estimate.log_prior,
                chi_square: estimate.chi_square,
                starts: [estimate.descents.len() as u64, reached.count() as u64],
            },
            tuned: self.tuned(estimate),
            findings: words::findings(&estimate.findings, &judged.leaning, &unknowns.names),
            warnings: self.warnings(&log_evidence, work),
            acceptance: chains.chains.iter().map(|chain| chain.moves.acceptance).collect(),
            draws: weighted.kept(KEPT),
            predictive_draws: 0,
            predictive: Vec::new(),
            p_value: None,
            leave_one_out: None,
            leave_one_phase_out: None,
            phases: Vec::new(),
            held_out: None,
            data: data.collect(),
            spent: Spent {
                likelihoods: work.likelihoods,
                gradients: work.gradients,
                rejected: work.rejections.total(),
            },
            parameters: parameters.collect(),
            handed_on: self.handed_on.iter().map(HandedOn::summary).collect(),
            handed_on_fits: self.fits.iter().map(|(_, fit)| fit.clone()).collect(),
            log_evidence,
        }
    }

    /// The posterior that is the prior of an unknown.
    fn handed_on_prior(
        &self,
        place: usize,
        shown: &dyn Fn(f64) -> f64,
        spread: &dyn Fn(f64) -> f64,
    ) -> Option<HandedOnPrior> {
        let parameter = self.likelihood().unknowns().model.get(place)?;
        self.handed_on.iter().find_map(|own| {
            let column = own.parameters.iter().position(|known| known == parameter)?;
            let [mean, sd, q025, q50, q975] = own.moments(column);
            let [mean, q025, q50, q975] = [mean, q025, q50, q975].map(shown);
            Some(HandedOnPrior { source: own.source.clone(), mean, sd: spread(sd), q025, q50, q975 })
        })
    }

    /// Most probable unknowns, then the model's other parameters as they were held.
    fn tuned(&self, estimate: &PointEstimate) -> Vec<(String, f64)> {
        let names = self.likelihood().names();
        let mut tuned: Vec<(String, f64)> = names.iter().cloned().zip(estimate.parameters.iter().copied()).collect();
        let full = self.likelihood().full_parameters(&estimate.parameters);
        for (parameter, value) in self.inputs.model.parameters.iter().zip(full) {
            if !names[..self.likelihood().model_parameters()].contains(&parameter.name) {
                tuned.push((parameter.name.clone(), value));
            }
        }
        tuned
    }

    fn warnings(&self, evidence: &Evidence, work: &Work) -> Vec<String> {
        let mut warnings = Vec::new();
        let (unknowns, readings) = (self.likelihood().dimension(), self.likelihood().data().len());
        if unknowns > readings {
            warnings.push(format!(
                "{unknowns} unknowns stand against {readings} readings: the priors decide a part of the result."
            ));
        }
        if let Some(k) = evidence.pareto_k.filter(|k| *k > 0.7) {
            warnings.push(format!(
                "The evidence is not to be trusted (Pareto k of its weights {k:.2}, wanted: 0.7 or less): `\"sampler\": \"smc\"` \
                 gives it independently."
            ));
        }
        for (source, fit) in &self.fits {
            warnings.extend(fit.doubts.iter().map(|doubt| {
                format!(
                    "The posterior of {source}, the prior here, is only roughly described by a normal distribution of its \
                     scores: {doubt}."
                )
            }));
        }
        for (reason, count) in &work.rejections.by_reason {
            warnings.push(format!("{count} evaluations failed: {reason}."));
        }
        warnings
    }

    fn predict_blocks(&self, output: Output) -> Result<Step, JobError> {
        let all = &output.draws.values;
        let count = POSTERIOR_CHECKS.min(all.len());
        let chosen: Vec<Vec<f64>> = (0..count).map(|k| all[(2 * k + 1) * all.len() / (2 * count)].clone()).collect();
        let priors = self.target.priors();
        let key = self.stream("calibrate prior");
        let points = Points::new(PointKind::Sobol, key, PRIOR_CHECKS, priors.len())
            .or_else(|_| Points::new(PointKind::MonteCarlo, key, PRIOR_CHECKS, priors.len()))
            .map_err(|e| JobError::Failed(e.to_string()))?;
        let mut row = vec![0.5; priors.len()];
        let before: Vec<Vec<f64>> = (0..PRIOR_CHECKS)
            .map(|index| {
                points.fill_row(index, &mut row);
                let at: Vec<f64> = priors.iter().zip(&row).map(|(prior, share)| prior.quantile(*share)).collect();
                self.target.parameters(&at)
            })
            .collect();
        let mut inputs = Vec::new();
        for (prior, draws) in [(false, &chosen), (true, &before)] {
            for draws in draws.chunks(BLOCK) {
                inputs.push(to_bytes(&PredictInput::Draws { prior, draws: draws.to_vec() })?);
            }
        }
        inputs.push(to_bytes(&PredictInput::Carry(Box::new(output)))?);
        Ok(Step::Blocks { stage: PREDICT.to_owned(), inputs })
    }

    fn predict(&self, prior: bool, draws: &[Vec<f64>]) -> Predicted {
        let names = self.likelihood().names();
        let inputs: Vec<String> = self.inputs.model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = self.inputs.model.nodes.iter().map(|node| node.name.clone()).collect();
        let mut workspace = self.predictor.workspace();
        let mut memory = self.likelihood().workspace();
        let mut pointwise = vec![0.0; self.likelihood().residual_count()];
        let mut predicted = Predicted::default();
        for draw in draws {
            let full = self.likelihood().full_parameters(draw);
            let find = |name: &str| names.iter().position(|known| known == name).map(|place| draw[place]);
            for measurement in self.measurements() {
                let settled = settled(measurement, &inputs, &nodes, &find);
                predicted.readings.extend(self.predictor.predict(&mut workspace, &settled, &full).readings);
            }
            if !prior {
                let squares = self.likelihood().pointwise(draw, &mut memory, &mut pointwise);
                predicted.squares.push(squares.unwrap_or(f64::NAN));
                if predicted.squares.last().is_some_and(|squares| squares.is_nan()) {
                    pointwise.fill(f64::NAN);
                }
                predicted.pointwise.extend(&pointwise);
            }
        }
        predicted
    }

    fn finish(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        let mut result = None;
        let empty = || Draws { values: Vec::new(), predicted: Predicted::default() };
        let (mut posterior, mut before) = (empty(), empty());
        for (input, bytes) in inputs.iter().zip(outputs) {
            match from_bytes(input, stage)? {
                PredictInput::Carry(output) => result = Some(output),
                PredictInput::Draws { prior, draws } => {
                    let own = if prior { &mut before } else { &mut posterior };
                    let block = Predicted::from_bytes(bytes, stage)?;
                    own.values.extend(draws);
                    own.predicted.readings.extend(block.readings);
                    own.predicted.pointwise.extend(block.pointwise);
                    own.predicted.squares.extend(block.squares);
                }
            }
        }
        let mut output = result.ok_or_else(|| JobError::Failed("the summary of the chains is not there".to_owned()))?;
        output.predictive =
            predictive::checks(&self.measurements(), &self.inputs.model, &output.order, &posterior, &before);
        output.predictive_draws = posterior.values.len() as u64;
        let readings = self.likelihood().residual_count();
        let tails: Vec<f64> = (posterior.predicted.squares.iter())
            .filter(|squares| squares.is_finite())
            .map(|&squares| chi_square_sf(squares, readings as f64))
            .collect();
        output.p_value = (!tails.is_empty()).then(|| tails.iter().sum::<f64>() / tails.len() as f64);
        let pointwise = &posterior.predicted.pointwise;
        let good = psis::greatest_good_shape(posterior.values.len());
        let validated = |found: &LeaveOneOut| CrossValidation {
            expected_log_density: found.expected_log_density,
            standard_error: found.standard_error,
            effective_parameters: found.effective_parameters,
            unreliable: found.pareto_k.iter().filter(|k| !(**k <= good)).count() as u64,
        };
        output.leave_one_out = psis::leave_one_out(pointwise, readings, 1.0).as_ref().map(validated);
        let measurements = self.measurements();
        let (groups, summed) = scores::by_phase(&measurements, self.likelihood().data(), pointwise);
        let left_out = psis::leave_one_out(&summed, groups.len(), 1.0);
        output.leave_one_phase_out = left_out.as_ref().map(validated);
        output.phases = scores::phases(&measurements, &groups, left_out.as_ref(), good, &output.order, &posterior);
        output.held_out = scores::held_out(&output.phases);
        serde_json::to_value(*output).map(Step::Done).map_err(|e| JobError::Failed(e.to_string()))
    }
}

impl Job for Calibrate {
    fn kind(&self) -> &'static str {
        "calibrate"
    }

    fn algorithm_version(&self) -> u32 {
        3
    }

    fn identity(&self) -> Value {
        let data: Vec<Value> = self.measurements().iter().map(|measurement| measurement.identity()).collect();
        let errors: Vec<Value> =
            self.inputs.input_errors.iter().map(|error| json!({ "sigma": error.sigma, "bias": error.bias })).collect();
        let mut identity = json!({
            "parameters": self.spec.parameters,
            "sampler": self.spec.sampler,
            "chains": self.spec.chains,
            "warmup": self.spec.warmup,
            "draws": self.spec.draws,
            "model": self.inputs.model.identity(),
            "priors": self.inputs.priors,
            "input_errors": errors,
            "data": data,
        });
        if !self.handed_on.is_empty() {
            identity["handed_on"] = self.handed_on.iter().map(HandedOn::identity).collect();
        }
        identity
    }

    fn begin(&self) -> Result<Step, JobError> {
        if let Some(own) = self.handed_on.iter().find(|own| own.draws.is_empty()) {
            return Err(JobError::Failed(format!("the posterior of {} has no draws", own.source)));
        }
        Ok(Step::Blocks { stage: ESTIMATE.to_owned(), inputs: vec![Vec::new()] })
    }

    fn block(&self, stage: &str, input: &[u8]) -> Result<Vec<u8>, JobError> {
        match stage {
            ESTIMATE => {
                let key = self.stream("calibrate estimate");
                let settings = PointSettings::default();
                let found = point_estimate::estimate(&self.target, &settings, &key, &[]);
                to_bytes(&found.map_err(|e| JobError::Failed(e.to_string()))?)
            }
            SAMPLE => self.sample(from_bytes(input, stage)?)?.into_bytes(),
            PREDICT => match from_bytes(input, stage)? {
                PredictInput::Draws { prior, draws } => Ok(self.predict(prior, &draws).to_bytes()),
                PredictInput::Carry(_) => Ok(Vec::new()),
            },
            _ => Err(JobError::Unreadable { stage: stage.to_owned(), reason: "there is no such stage".to_owned() }),
        }
    }

    fn reduce(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        match stage {
            ESTIMATE => {
                let bytes = outputs.first().map_or(&[][..], Vec::as_slice);
                self.after_estimate(&from_bytes(bytes, stage)?)
            }
            SAMPLE => self.after_samples(stage, inputs, outputs),
            _ => self.finish(stage, inputs, outputs),
        }
    }
}
