//! From the chains to the result: whether they can be believed, the evidence, summaries by parameter.

use super::block::Partial;
use super::monte_carlo::{self, Shown};
use super::output::{Evidence, MostProbable, Output, ParameterSummary, PosteriorPriorOf, Spent, UsedData};
use super::summary::Weighted;
use super::{Calibrate, words};
use crate::document::counted;
use crate::expression::Unit;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::likelihood::rows::used_rows;
use crate::inference::posterior::Work;
use crate::inference::sampler::chains::{Chain, Chains};
use crate::inference::sampler::convergence::{self, Convergence, ConvergenceLimits};
use crate::inference::sampler::importance::ImportanceEstimate;
use crate::inference::sampler::smc::{self, Island};
use crate::inference::target::{LeastSquares, Target};
use crate::job::key_number::KeyNumber;
use crate::job::{Done, JobError, Step};
use crate::measurement::Doubt;
use crate::measurement::scatter;
use crate::study::posterior_prior::PosteriorPrior;

/// Draws kept of all chains.
const KEPT: usize = 1000;
/// Error of the log evidence above which the weights of the islands are too uneven.
const EVIDENCE_ERROR: f64 = 0.5;

/// What the blocks of sampling gave, over the unknowns.
#[derive(Default)]
pub(super) struct Sampled {
    /// Chains.
    pub chains: Vec<Chain>,
    /// Islands of particles.
    pub islands: Vec<Island>,
    /// The evidence by importance sampling.
    pub importance: Option<ImportanceEstimate>,
}

impl Calibrate {
    /// Sorts what the blocks of sampling gave.
    pub(super) fn sampled(&self, blocks: Done<Self>) -> Sampled {
        let mut sampled = Sampled::default();
        for (_, partial) in blocks {
            match partial {
                Partial::Chain(chain) => sampled.chains.push(self.target.chain(chain)),
                Partial::Island(island) => {
                    let mut island = *island;
                    island.chain = self.target.chain(island.chain);
                    sampled.islands.push(island);
                }
                Partial::Evidence(evidence) => sampled.importance = evidence,
                Partial::Estimate(_) | Partial::Predicted(_) => {}
            }
        }
        sampled
    }

    /// Judges and summarises the chains.
    pub(super) fn after_samples(&self, estimate: &PointEstimate, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let estimate = self.target.estimate(estimate);
        let Sampled { chains, islands, importance } = self.sampled(blocks);
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
        let chains = if self.spec.sampler.method().has_islands() {
            let result = smc::combine(&names, islands);
            if !result.finished {
                objections.push("an island did not reach the posterior within its stages".to_owned());
            }
            let error = result.log_evidence_error;
            if !(error <= EVIDENCE_ERROR) {
                objections.push(format!("the islands know the logarithm of the evidence only to {error:.2}"));
            }
            evidence.value = Some(result.log_evidence).filter(|value| value.is_finite());
            evidence.sd = Some(error).filter(|value| value.is_finite());
            evidence.method = "smc".to_owned();
            weights = Some(result.weights);
            result.chains
        } else {
            if let Some(estimated) = &importance {
                evidence.value = Some(estimated.log_evidence);
                evidence.sd = Some(estimated.log_evidence_error);
                evidence.method = "importance sampling".to_owned();
                evidence.pareto_k = estimated.pareto_k;
            }
            Chains { names: names.clone(), chains }
        };
        if chains.is_empty() || chains.chains.iter().any(|chain| chain.len() != chains.chains[0].len()) {
            return Err(JobError::Failed("the chains have no draws, or not equally many".to_owned()));
        }
        let judged = convergence::judge(&chains, self.likelihood().priors(), &ConvergenceLimits::default());
        objections.extend(words::objections(&judged, &names));
        for posterior_prior in self.posterior_priors.iter().filter(|posterior_prior| !posterior_prior.converged) {
            objections.push(format!(
                "the prior is the posterior of {}, whose chains did not converge",
                posterior_prior.source
            ));
        }
        let mut work = chains.work();
        work.merge(&estimate.work);
        if let Some(estimated) = &importance {
            work.merge(&estimated.work);
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
            let diagnostics = &judged.parameters[place];
            let quantiles = weighted.quantiles(place, &[0.025, 0.5, 0.975]);
            let summary = ParameterSummary {
                unit: text.clone(),
                prior: unknowns.priors[place],
                posterior_prior: self.posterior_prior_of(place, &shown, &spread),
                mean: shown(weighted.mean(place)),
                sd: spread(weighted.covariance(place, place).sqrt()),
                q025: shown(quantiles[0]),
                q50: shown(quantiles[1]),
                q975: shown(quantiles[2]),
                rhat: diagnostics.r_hat,
                ess_bulk: diagnostics.ess_bulk,
                ess_tail: diagnostics.ess_tail,
                mcse_mean: diagnostics.mcse_mean.map(spread),
                at_bound: diagnostics.share_at_lower.unwrap_or(0.0) + diagnostics.share_at_upper.unwrap_or(0.0),
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
            key_numbers: self.key_numbers(chains, weights),
            correlations: weighted.correlations(unknowns.len()),
            most_probable: MostProbable {
                log_likelihood: estimate.log_likelihood,
                log_prior: estimate.log_prior,
                chi_square: estimate.chi_square,
                starts: [estimate.descents.len() as u64, reached.count() as u64],
            },
            tuned: self.tuned(estimate),
            findings: self.findings(words::findings(&estimate.findings, &judged.leaning, &unknowns.names, &|place| {
                self.is_surrogate_error(&unknowns.names[place])
            })),
            warnings: self.warnings(estimate, &log_evidence, work),
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
            posterior_priors: self.posterior_priors.iter().map(PosteriorPrior::summary).collect(),
            posterior_prior_fits: self.fits.iter().map(|(_, fit)| fit.clone()).collect(),
            log_evidence,
        }
    }

    /// Numbers of the posterior with their Monte Carlo errors, in the unknowns' units.
    pub(in crate::job) fn key_numbers(&self, chains: &Chains, weights: Option<&[f64]>) -> Vec<KeyNumber> {
        let unknowns = self.likelihood().unknowns();
        let shown = unknowns.names.iter().zip(&unknowns.units).map(|(name, text)| {
            let unit = Unit::parse(text).ok();
            let of_difference = unit.clone();
            Shown {
                name,
                unit: text,
                value: Box::new(move |value| unit.as_ref().map_or(value, |unit| unit.from_si(value))),
                difference: Box::new(move |value| {
                    of_difference.as_ref().map_or(value, |unit| unit.difference_from_si(value))
                }),
            }
        });
        monte_carlo::numbers(chains, weights, &shown.collect::<Vec<_>>())
    }

    /// The posterior that is the prior of an unknown.
    fn posterior_prior_of(
        &self,
        place: usize,
        shown: &dyn Fn(f64) -> f64,
        spread: &dyn Fn(f64) -> f64,
    ) -> Option<PosteriorPriorOf> {
        let parameter = self.likelihood().unknowns().model.get(place)?;
        self.posterior_priors.iter().find_map(|posterior_prior| {
            let column = posterior_prior.parameters.iter().position(|inferred| inferred == parameter)?;
            let [mean, sd, q025, q50, q975] = posterior_prior.moments(column);
            let [mean, q025, q50, q975] = [mean, q025, q50, q975].map(shown);
            Some(PosteriorPriorOf { source: posterior_prior.source.clone(), mean, sd: spread(sd), q025, q50, q975 })
        })
    }

    /// That the stated noise is larger than what the readings scatter by about the best fit.
    fn overstated(&self, estimate: &PointEstimate) -> Option<String> {
        let likelihood = self.likelihood();
        let mut residuals = vec![0.0; likelihood.residual_count()];
        likelihood.residuals(&estimate.parameters, &mut likelihood.workspace(), &mut residuals).ok()?;
        let measurements = self.measurements();
        let whitened = likelihood
            .data()
            .iter()
            .zip(&residuals)
            .map(|(datum, residual)| (&measurements[datum.measurement].sensors[datum.sensor], *residual));
        let sensors = scatter::of_stated(whitened, &self.inputs.model);
        scatter::warning(&sensors, estimate.held.iter().filter(|held| held.is_none()).count())
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

    /// What is doubtful about the data; a start apart from its first readings, or all else.
    fn doubts(&self, of_start: bool) -> impl Iterator<Item = String> {
        let all = self.measurements().into_iter().flat_map(|measurement| &measurement.doubts);
        all.filter(move |doubt| doubt.is_of_start() == of_start).map(Doubt::in_words)
    }

    /// Findings about parameters after what bends them all.
    fn findings(&self, of_parameters: Vec<String>) -> Vec<String> {
        self.doubts(true).chain(of_parameters).collect()
    }

    /// Whether an unknown is an error of the surrogate that answers for the model.
    fn is_surrogate_error(&self, name: &str) -> bool {
        let model = &self.inputs.model;
        let errors = model.external.as_ref().map_or(0..0, |external| external.errors.clone());
        model.parameters.get(errors).is_some_and(|errors| errors.iter().any(|error| error.name == name))
    }

    fn warnings(&self, estimate: &PointEstimate, evidence: &Evidence, work: &Work) -> Vec<String> {
        let mut warnings: Vec<String> = self.doubts(false).collect();
        warnings.extend(self.overstated(estimate));
        let names = &self.likelihood().unknowns().names;
        let unknowns = names.iter().filter(|name| !self.is_surrogate_error(name)).count();
        let readings = self.likelihood().data().len();
        if unknowns > readings {
            warnings.push(format!(
                "{} against {}: the priors decide a part of the result.",
                counted(unknowns, "unknown"),
                counted(readings, "reading")
            ));
        }
        if let (Some(k), Some(remedy)) = (evidence.pareto_k, evidence.remedy()) {
            warnings.push(format!(
                "The evidence is not to be trusted (Pareto k of its weights {k:.2}, wanted: 0.7 or less): `{remedy}` \
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
            warnings.push(format!("{} failed: {reason}.", counted(*count, "evaluation")));
        }
        warnings
    }
}
