//! From a pass's resolved jobs to jobs that can run.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::diagnosis::{PRIOR_OF, Problem};
use crate::document::{Diagnostic, code, suggest};
use crate::effect::candidates;
use crate::inference::likelihood::InputError;
use crate::inference::measurement::Measurement;
use crate::job::calibrate::{self, Calibrate, Inputs};
use crate::job::compare::{self, Compare, Tuned};
use crate::job::conventional::{self, Conventional};
use crate::job::design::Design;
use crate::job::diagnose::{self, Diagnose};
use crate::job::goal::Goal;
use crate::job::handed_on::HandedOn;
use crate::job::predict::Predict;
use crate::job::propagate::{self, Propagate};
use crate::job::sensitivity::Sensitivity;
use crate::job::{JobError, Runnable};
use crate::random::Distribution;
use crate::thermal::Model;

use super::model::Prior;
use super::resolve::sensor_places;
use super::resolved::{Blocked, HandedOnPrior, JobSpec, NamedJob, Pass, Prediction, Upstream};

/// Parameters named in a message.
const NAMED: usize = 12;

/// A pass's job: ready, or why it does not run now.
pub enum Readiness {
    /// It can run.
    Ready(Arc<dyn Runnable>),
    /// It can run when calibrations of the study have their results.
    After(Box<Deferred>),
    /// It does not run now; the reason in a line.
    NotRun(String),
    /// It cannot be made from its definition; what is wrong, at its place.
    Refused(Vec<Diagnostic>),
}

/// Makes a job from the results that it waits for.
type Prepare = Box<dyn Fn(&[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> + Send + Sync>;

/// A job that waits for calibrations.
pub struct Deferred {
    /// The calibrations.
    pub from: Vec<Upstream>,
    /// The job as far as it is known before.
    known: Arc<dyn Runnable>,
    /// What decides the result beside the job's own identity and the calibrations.
    beside: Option<Value>,
    prepare: Prepare,
}

impl Deferred {
    /// The job as far as it is known before: kind and version.
    pub fn job(&self) -> &dyn Runnable {
        self.known.as_ref()
    }

    /// Everything that decides the result, beside the calibrations.
    pub fn identity(&self) -> Value {
        match &self.beside {
            None => self.known.identity(),
            Some(beside) => json!({ "job": self.known.identity(), "handed_on": beside }),
        }
    }

    /// Makes the job ready; `results` are those of [`Deferred::from`], in that order.
    ///
    /// # Errors
    /// Results that do not have what the job needs, draws that no density describes.
    pub fn prepare(&self, results: &[Arc<Value>]) -> Result<Arc<dyn Runnable>, JobError> {
        (self.prepare)(results)
    }
}

/// What the jobs of a pass share.
struct Shared<'p> {
    pass: &'p Pass,
    model: Arc<Model>,
    measurements: Arc<Vec<Measurement>>,
    /// Calibrations that cannot be made.
    refused: Vec<String>,
}

/// The jobs of a pass in order, each by its name. One that cannot be made from its definition (a network without a path
/// to a boundary, a nominal case that does not solve) keeps none of the others.
pub fn ready(pass: &Pass) -> Vec<(String, Readiness)> {
    let mut shared = Shared {
        pass,
        model: Arc::new(pass.model.clone()),
        measurements: Arc::new(pass.measurements.clone()),
        refused: pass.refused.iter().map(|refused| refused.job.clone()).collect(),
    };
    // Comparisons show the delivered state where the tuned one cannot be had: so calibrations come first.
    let is_calibration = |named: &NamedJob| matches!(named.spec, JobSpec::Calibrate(_));
    let calibrations = pass.jobs.iter().filter(|named| is_calibration(named));
    let mut made: Vec<(&str, Readiness)> =
        calibrations.map(|named| (named.name.as_str(), shared.readiness(named))).collect();
    let cannot = made.iter().filter(|(_, readiness)| matches!(readiness, Readiness::Refused(_)));
    shared.refused.extend(cannot.map(|(name, _)| (*name).to_owned()));
    let mut take = |named: &NamedJob| {
        let known = made.iter().position(|(name, _)| *name == named.name);
        known.map_or_else(|| shared.readiness(named), |known| made.swap_remove(known).1)
    };
    pass.jobs.iter().map(|named| (named.name.clone(), take(named))).collect()
}

/// A comparison of a pass without the tuned state; `None` for other jobs.
pub fn delivered(pass: &Pass, named: &NamedJob) -> Option<Readiness> {
    let JobSpec::Compare(spec) = &named.spec else { return None };
    let shared = Shared {
        pass,
        model: Arc::new(pass.model.clone()),
        measurements: Arc::new(pass.measurements.clone()),
        refused: spec.calibration.iter().cloned().collect(),
    };
    shared.comparison(spec).ok()
}

/// What is wrong with the definition of a job, in general: at its name.
pub fn refusal(named: &NamedJob, reason: impl std::fmt::Display) -> Diagnostic {
    let message = format!("{}{reason}", refusal_prefix(&named.name));
    Diagnostic::error(&code::JOB_REFUSED, &named.place, message)
}

/// What stands before the reason in the message of a [`refusal`].
pub fn refusal_prefix(name: &str) -> String {
    format!("job `{name}` cannot be made: ")
}

/// Why a job of a pass does not run now; `None` where it does.
pub fn blocked(pass: &Pass, name: &str) -> Option<Blocked> {
    if let Some(refused) = pass.refused.iter().find(|refused| refused.job == name) {
        return Some(Blocked { reason: refused.diagnostic.message.clone(), is_wrong: true });
    }
    let after = |source: &str, own: &Blocked| Blocked {
        reason: format!("it builds on the posterior of {source}, which does not run: {}", own.reason),
        is_wrong: own.is_wrong,
    };
    let of = |own: &HandedOnPrior| Some(after(&own.draws.source, own.blocked.as_ref()?));
    let wrong = |reason: String| Blocked { reason, is_wrong: true };
    let waits = |reason: String| Blocked { reason, is_wrong: false };
    match &pass.jobs.iter().find(|job| job.name == name)?.spec {
        JobSpec::Propagate(_) | JobSpec::Conventional(_) => pass.handed_on.iter().find_map(of),
        JobSpec::Calibrate(spec) => priors_of(pass, &spec.parameters).iter().find_map(of),
        JobSpec::Diagnose(spec) => priors_of(pass, &spec.parameters).iter().find_map(of),
        JobSpec::Sensitivity(_) | JobSpec::Goal(_) | JobSpec::Design(_) => pass.handed_on.first().map(|own| {
            wrong(format!(
                "it takes independent distributions as priors, and {} has the draws of {}",
                suggest::listed(own.draws.names.iter().map(String::as_str), NAMED),
                own.draws.source
            ))
        }),
        JobSpec::Predict(spec) => {
            let own = match &spec.posterior.from {
                Some(from) if from.file == pass.file => {
                    blocked(pass, &from.job).map(|own| after(&spec.posterior.draws.source, &own))
                }
                _ => of(&spec.posterior),
            };
            own.or_else(|| rest(pass, spec).iter().find_map(of)).or_else(|| spec.handed_on.iter().find_map(of))
        }
        // A sensor without noise keeps a calibration from running, not the comparison that would show it.
        JobSpec::Compare(spec) => {
            let calibration = spec.calibration.as_ref().filter(|name| !is_refused(pass, name))?;
            let runs = |name: &str| {
                pass.jobs.iter().any(|other| other.name == name && matches!(other.spec, JobSpec::Calibrate(_)))
            };
            let own = if runs(calibration) { blocked(pass, calibration) } else { Some(waits(String::new())) };
            let reason = || format!("it shows the tuned state of `{calibration}`, which does not run");
            own.map(|own| Blocked { reason: reason(), ..own })
        }
        JobSpec::Waiting { measurements, command, .. } => Some(waits(format!(
            "the data of {} are not here; bring them with `{command}`",
            measurements.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        ))),
        JobSpec::NotYet { reason, .. } => Some(waits(reason.clone())),
    }
}

fn is_refused(pass: &Pass, job: &str) -> bool {
    pass.refused.iter().any(|refused| refused.job == job)
}

/// Draws that stand in for priors of the parameters that a calibration or a diagnosis infers.
fn priors_of(pass: &Pass, parameters: &[usize]) -> Vec<HandedOnPrior> {
    let used = |own: &&HandedOnPrior| own.draws.parameters.iter().any(|index| parameters.contains(index));
    pass.handed_on.iter().filter(used).cloned().collect()
}

/// Draws that stand in for priors of the parameters that a prediction's calibration did not infer.
fn rest(pass: &Pass, spec: &Prediction) -> Vec<HandedOnPrior> {
    let mut rest = Vec::new();
    for own in &pass.handed_on {
        let kept: Vec<usize> = (0..own.draws.parameters.len())
            .filter(|&place| !spec.posterior.draws.parameters.contains(&own.draws.parameters[place]))
            .collect();
        if !kept.is_empty() {
            rest.push(HandedOnPrior { draws: own.draws.with(&kept), ..own.clone() });
        }
    }
    rest
}

/// The draws, those of calibrations from their results; takes as many results as there are calibrations.
fn filled(draws: &[HandedOnPrior], results: &mut std::slice::Iter<'_, Arc<Value>>) -> Result<Vec<HandedOn>, JobError> {
    let missing = || JobError::Failed("a result is not there".to_owned());
    let fill = |own: &HandedOnPrior| match own.from {
        None => Ok(own.draws.clone()),
        Some(_) => own.draws.filled(results.next().ok_or_else(missing)?),
    };
    draws.iter().map(fill).collect()
}

/// The draws as far as they are known before.
fn unfilled(draws: &[HandedOnPrior]) -> Vec<HandedOn> {
    draws.iter().map(|own| own.draws.clone()).collect()
}

/// A job that waits for the calibrations behind these draws; ready at once where they are of none.
fn after(draws: &[&[HandedOnPrior]], known: Arc<dyn Runnable>, prepare: Prepare) -> Result<Readiness, JobError> {
    let from: Vec<Upstream> = draws.iter().flat_map(|list| list.iter()).filter_map(|own| own.from.clone()).collect();
    if from.is_empty() {
        return prepare(&[]).map(Readiness::Ready);
    }
    Ok(Readiness::After(Box::new(Deferred { from, known, beside: None, prepare })))
}

impl Shared<'_> {
    fn readiness(&self, named: &NamedJob) -> Readiness {
        let own = self.pass.refused.iter().filter(|refused| refused.job == named.name);
        let own: Vec<Diagnostic> = own.map(|refused| refused.diagnostic.clone()).collect();
        match blocked(self.pass, &named.name) {
            Some(_) if !own.is_empty() => Readiness::Refused(own),
            Some(Blocked { reason, is_wrong: false }) => Readiness::NotRun(reason),
            Some(Blocked { reason, is_wrong: true }) => Readiness::Refused(vec![refusal(named, reason)]),
            None => {
                let job = self.job(&named.name, &named.spec);
                job.unwrap_or_else(|error| Readiness::Refused(vec![refusal(named, error)]))
            }
        }
    }

    fn job(&self, name: &str, spec: &JobSpec) -> Result<Readiness, JobError> {
        match spec {
            JobSpec::Propagate(spec) => self.propagation(name, spec),
            JobSpec::Predict(spec) => self.prediction(name, spec),
            JobSpec::Conventional(spec) => self.conventional(spec),
            JobSpec::Compare(spec) => self.comparison(spec),
            JobSpec::Calibrate(spec) => self.calibration(name, spec),
            JobSpec::Diagnose(spec) => self.diagnosis(name, spec),
            JobSpec::Sensitivity(spec) => {
                let (model, priors) = (Arc::clone(&self.model), self.pass.priors.clone());
                let job = Sensitivity::new(spec.clone(), model, priors, self.pass.seed, name)?;
                Ok(Readiness::Ready(Arc::new(job)))
            }
            JobSpec::Design(spec) => {
                let (model, priors) = (Arc::clone(&self.model), self.pass.priors.clone());
                Ok(Readiness::Ready(Arc::new(Design::new(spec.clone(), model, priors, self.pass.seed, name)?)))
            }
            JobSpec::Goal(spec) => {
                let (model, priors) = (Arc::clone(&self.model), self.pass.priors.clone());
                Ok(Readiness::Ready(Arc::new(Goal::new(spec.clone(), model, priors, self.pass.seed, name)?)))
            }
            // Blocked, with the reason.
            JobSpec::Waiting { .. } | JobSpec::NotYet { .. } => Ok(Readiness::NotRun(String::new())),
        }
    }

    /// A propagation with these priors, draws not yet in their place.
    fn propagate(
        &self,
        name: &str,
        spec: &propagate::Spec,
        priors: &[Distribution],
    ) -> impl Fn() -> Result<Propagate, JobError> + Send + Sync + use<> {
        let (spec, model, priors) = (spec.clone(), Arc::clone(&self.model), priors.to_vec());
        let (seed, name) = (self.pass.seed, name.to_owned());
        move || Propagate::new(spec.clone(), Arc::clone(&model), priors.clone(), seed, &name)
    }

    fn propagation(&self, name: &str, spec: &propagate::Spec) -> Result<Readiness, JobError> {
        let draws = self.pass.handed_on.clone();
        let make = self.propagate(name, spec, &self.pass.priors);
        let known = make()?.with_handed_on(unfilled(&draws));
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(known)));
        }
        let own = draws.clone();
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            Ok(Arc::new(make()?.with_handed_on(filled(&own, &mut results.iter())?)))
        };
        after(&[&draws], Arc::new(known), Box::new(prepare))
    }

    fn prediction(&self, name: &str, spec: &Prediction) -> Result<Readiness, JobError> {
        let mut priors = self.pass.priors.clone();
        for &(index, prior) in &spec.priors {
            priors[index] = prior;
        }
        let plain = self.propagate(name, &spec.propagate, &priors);
        let (discrepancy, seed, named) = (spec.discrepancy.clone(), self.pass.seed, name.to_owned());
        let make = move || plain()?.with_discrepancy(discrepancy.clone(), seed, &named);
        let (own, before, rest) = (vec![spec.posterior.clone()], spec.handed_on.clone(), rest(self.pass, spec));
        let join = |first: Vec<HandedOn>, rest: &[HandedOn]| first.into_iter().chain(rest.iter().cloned()).collect();
        let others = unfilled(&rest);
        let prior = make()?.with_handed_on(join(unfilled(&before), &others));
        let known = Predict::new(prior, make()?.with_handed_on(join(unfilled(&own), &others)));
        let draws = [own.clone(), before.clone(), rest.clone()];
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let mut results = results.iter();
            let own = filled(&own, &mut results)?;
            let before = filled(&before, &mut results)?;
            let others = filled(&rest, &mut results)?;
            let prior = make()?.with_handed_on(join(before, &others));
            Ok(Arc::new(Predict::new(prior, make()?.with_handed_on(join(own, &others)))))
        };
        after(&[&draws[0], &draws[1], &draws[2]], Arc::new(known), Box::new(prepare))
    }

    /// Worst cases are stacked from the ends of the draws' intervals of three standard deviations.
    fn conventional(&self, spec: &conventional::Spec) -> Result<Readiness, JobError> {
        let draws = self.pass.handed_on.clone();
        let (spec, model, priors) = (spec.clone(), Arc::clone(&self.model), self.pass.priors.clone());
        let make = move |draws: &[HandedOn]| {
            let mut priors = priors.clone();
            for own in draws.iter().filter(|own| !own.draws.is_empty()) {
                for (place, &parameter) in own.parameters.iter().enumerate() {
                    priors[parameter] = own.interval(place);
                }
            }
            Conventional::new(spec.clone(), Arc::clone(&model), priors)
        };
        let known: Arc<dyn Runnable> = Arc::new(make(&[])?);
        // The job itself knows intervals only: whose they are must be told.
        let beside: Value = draws.iter().map(|own| own.draws.identity()).collect();
        let own = draws.clone();
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            Ok(Arc::new(make(&filled(&own, &mut results.iter())?)?))
        };
        let mut readiness = after(&[&draws], known, Box::new(prepare))?;
        if let Readiness::After(deferred) = &mut readiness {
            deferred.beside = Some(beside);
        }
        Ok(readiness)
    }

    fn calibration(&self, name: &str, spec: &calibrate::Spec) -> Result<Readiness, JobError> {
        let draws = priors_of(self.pass, &spec.parameters);
        let inputs = Inputs {
            model: Arc::clone(&self.model),
            priors: self.pass.priors.clone(),
            measurements: Arc::clone(&self.measurements),
            input_errors: input_errors(self.pass),
        };
        let known = Calibrate::new(spec.clone(), inputs.clone(), self.pass.seed, name)?;
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(known)));
        }
        let known = known.with_handed_on(unfilled(&draws).into_iter().map(|own| own.with_no_draws()).collect())?;
        let (own, spec, seed, name) = (draws.clone(), spec.clone(), self.pass.seed, name.to_owned());
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let job = Calibrate::new(spec.clone(), inputs.clone(), seed, &name)?;
            Ok(Arc::new(job.with_handed_on(filled(&own, &mut results.iter())?)?))
        };
        after(&[&draws], Arc::new(known), Box::new(prepare))
    }

    fn diagnosis(&self, name: &str, spec: &diagnose::Spec) -> Result<Readiness, JobError> {
        let pass = self.pass;
        let chosen: Vec<Measurement> = spec.data.iter().map(|&index| self.measurements[index].clone()).collect();
        let sensors = sensor_places(chosen.iter());
        let mut candidates = candidates(&self.model, &pass.groups, &sensors, &pass.catalogue);
        candidates.retain(|candidate| spec.effects.contains(&candidate.effect));
        let problem = Problem {
            model: Arc::new(Model { keeps_signs: false, ..pass.model.clone() }),
            priors: pass.priors.clone(),
            parameters: spec.parameters.clone(),
            measurements: chosen,
            input_errors: input_errors(pass),
            catalogue: Arc::clone(&pass.catalogue),
            candidates,
            joint: Vec::new(),
            most_steps: Vec::new(),
        };
        let problem = if spec.effects.iter().any(|name| name == PRIOR_OF) {
            // Those of adopted effects stand behind the model's own.
            let adopted = pass.adopted.iter().map(|adopted| adopted.parameters.start).min();
            problem.with_priors_in_question(adopted.unwrap_or(usize::MAX))
        } else {
            problem
        };
        let draws = priors_of(pass, &spec.parameters);
        let known = Diagnose::new(spec.clone(), problem.clone(), pass.seed, name)?;
        if draws.is_empty() {
            return Ok(Readiness::Ready(Arc::new(known)));
        }
        let known = known.with_handed_on(unfilled(&draws).into_iter().map(|own| own.with_no_draws()).collect())?;
        let (own, spec, seed, name) = (draws.clone(), spec.clone(), pass.seed, name.to_owned());
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let job = Diagnose::new(spec.clone(), problem.clone(), seed, &name)?;
            Ok(Arc::new(job.with_handed_on(filled(&own, &mut results.iter())?)?))
        };
        after(&[&draws], Arc::new(known), Box::new(prepare))
    }

    fn comparison(&self, spec: &compare::Spec) -> Result<Readiness, JobError> {
        let nominal: Vec<f64> = self.pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
        let shown = spec.calibration.clone().filter(|name| !self.refused.contains(name));
        let spec = compare::Spec { calibration: shown.clone(), ..spec.clone() };
        let (model, measurements) = (Arc::clone(&self.model), Arc::clone(&self.measurements));
        let make = move || Compare::new(spec.clone(), Arc::clone(&model), Arc::clone(&measurements), nominal.clone());
        let known: Arc<dyn Runnable> = Arc::new(make()?);
        let Some(name) = shown else { return Ok(Readiness::Ready(known)) };
        let from = vec![Upstream { file: self.pass.file.clone(), job: name.clone() }];
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let result = results.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
            Ok(Arc::new(make()?.with_tuned(Tuned::from_result(&name, result)?)))
        };
        Ok(Readiness::After(Box::new(Deferred { from, known, beside: None, prepare: Box::new(prepare) })))
    }
}

/// Own errors of the inputs; a prior from draws was refused when the pass was read.
pub(super) fn input_errors(pass: &Pass) -> Vec<InputError> {
    let bias = |prior: &Option<Prior>| match prior {
        Some(Prior::Distribution(distribution)) => Some(*distribution),
        _ => None,
    };
    pass.input_errors.iter().map(|error| InputError { sigma: error.sigma, bias: bias(&error.bias) }).collect()
}
