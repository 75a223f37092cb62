//! Predictions: whose posterior is carried, to what.

use super::Kind;
use super::form::{AddedForm, PredictForm};
use super::run::{self, Prediction};
use crate::document::prior::PosteriorForm;
use crate::document::{NameOr, Place, code};
use crate::expression::Symbol;
use crate::job::discrepancy;
use crate::job::goal::discrepancies;
use crate::job::kind::JobKind;
use crate::job::propagate::{self, PropagateForm};
use crate::random::Distribution;
use crate::study::blocked::blocked as blocked_job;
use crate::study::job::{Asked, CALIBRATION, Entry, Forms, Inference, JobSpec};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolve::posterior_prior;
use crate::study::resolve::scope::Scope;
use crate::study::resolved::{PosteriorReference, Upstream};
use crate::thermal::QuantityValue;

/// What of the calibration's pass a prediction needs.
struct Source<'p> {
    parameters: Vec<String>,
    priors: &'p [Distribution],
    posterior_priors: &'p [PosteriorReference],
    posterior: PosteriorReference,
    inference: Inference<'p>,
}

/// Resolves the settings of a prediction.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &PredictForm, asked: &mut Asked) -> Option<JobSpec> {
    let offered = asked.offered;
    let before = scope.diagnostics.errors();
    let written = PropagateForm {
        quantities: form.quantities.clone(),
        samples: form.samples.clone(),
        sampling: form.sampling,
        environments: form.environments.clone(),
        requirements: form.requirements.clone(),
        sweep: form.sweep.clone(),
        joint: form.joint.clone(),
        failure_limit: form.failure_limit.clone(),
    };
    let spec = propagate::resolve(scope, &written, offered);
    let written_discrepancy = form.with.as_ref().and_then(|with| with.discrepancy.as_ref());
    let mut discrepancy = Vec::new();
    if let Some(AddedForm::Sizes(written)) = written_discrepancy {
        discrepancy = discrepancies(scope, written);
        if let Some(spec) = &spec {
            for (declared, written) in discrepancy.iter().zip(written) {
                if !spec.quantities.contains(&declared.quantity) {
                    let message = format!("`{}` is no quantity of this prediction", written.name);
                    let expected = "one of its `quantities`, or of its requirements where it says none";
                    scope.error(&code::JOB_SETTING, &written.name_place, message, expected);
                }
            }
        }
    }
    let pass;
    let source = match &form.from {
        Some(NameOr::Other(from)) => {
            let PosteriorForm { pass: file, job } = &from.value;
            pass = asked.upstreams.pass(scope, &file.value, &file.place)?;
            let inference_of_job = posterior_prior::calibration(scope, &pass, &job.value, &job.place)?;
            let posterior = posterior_prior::of_calibration(&pass, &job.value, &from.place, inference_of_job);
            let Some(inference) = inference_of_job else {
                let reason = posterior.blocked.map(|blocked| blocked.reason).unwrap_or_default();
                return Some(JobSpec::NotYet { kind: Kind::NAME, reason });
            };
            Source {
                parameters: pass.model.parameters.iter().map(|parameter| parameter.name.clone()).collect(),
                priors: &pass.priors,
                posterior_priors: &pass.posterior_priors,
                posterior,
                inference,
            }
        }
        source_in_pass => {
            let written = match source_in_pass {
                Some(NameOr::Name(name)) => Some((name.value.as_str(), &name.place)),
                _ => None,
            };
            let (job, place) = own_calibration(scope, entry, written, asked.forms)?;
            let spec = asked.jobs.iter().find(|named_job| named_job.name == job).map(|named_job| &named_job.spec);
            match (spec, spec.and_then(JobSpec::inference)) {
                (_, Some(inference)) => Source {
                    parameters: scope
                        .resolved
                        .model
                        .parameters
                        .iter()
                        .map(|parameter| parameter.name.clone())
                        .collect(),
                    priors: offered.priors,
                    posterior_priors: offered.posterior_priors,
                    posterior: of_this_pass(offered.file, &job, &place),
                    inference,
                },
                (Some(JobSpec::Waiting { measurements, command, .. }), None) => {
                    let (measurements, command) = (measurements.clone(), command.clone());
                    return Some(JobSpec::Waiting { kind: Kind::NAME, measurements, command });
                }
                // Its settings are wrong, which has been reported.
                _ => return None,
            }
        }
    };
    let mut prediction = Prediction { discrepancy, ..assemble(scope, source, spec?) };
    match written_discrepancy.map(|written| added(scope, asked, written, &prediction)) {
        Some(Added::Known(known)) => prediction.added = Some(known),
        Some(Added::NotYet(spec)) => return Some(spec),
        Some(Added::Nothing) | None => {}
    }
    (scope.diagnostics.errors() == before).then(|| JobSpec::of(prediction))
}

/// What a discrepancy job adds.
enum Added {
    Known(run::Added),
    /// It waits for something.
    NotYet(JobSpec),
    /// Sizes are added, or what is wrong has been reported.
    Nothing,
}

/// The discrepancy job that is asked for, and to which quantities its sensors add.
fn added(scope: &mut Scope, asked: &mut Asked, written: &AddedForm, prediction: &Prediction) -> Added {
    let other;
    let (file, name, place, jobs, measurements, model) = match written {
        AddedForm::Sizes(_) => return Added::Nothing,
        AddedForm::Own(name) => {
            let offered = asked.offered;
            (offered.file.to_owned(), name.value.clone(), &name.place, asked.jobs, offered.data, None)
        }
        AddedForm::Other(from) => {
            let PosteriorForm { pass: file, job } = &from.value;
            let Some(pass) = asked.upstreams.pass(scope, &file.value, &file.place) else { return Added::Nothing };
            other = pass;
            let (jobs, measurements) = (other.jobs.as_slice(), other.measurements.as_slice());
            (other.file.clone(), job.value.clone(), &job.place, jobs, measurements, Some(&other.model))
        }
    };
    let is_own = model.is_none();
    let source = if is_own { format!("`{name}`") } else { format!("`{name}` of `{file}`") };
    let spec = jobs.iter().find(|job| job.name == name).map(|job| &job.spec);
    let known = match spec {
        Some(spec) if spec.kind() == discrepancy::Kind::NAME => spec.get::<discrepancy::Spec>(),
        Some(other) => {
            let message = format!("{source} is a `{}` job", other.kind());
            scope.error(&code::PREDICTION, place, message, "a `discrepancy` job, or standard deviations by quantity");
            return Added::Nothing;
        }
        // One of this pass whose settings are wrong has been reported.
        None if is_own && asked.forms.kind(&name) == Some(discrepancy::Kind::NAME) => return Added::Nothing,
        None if is_own && asked.forms.kind(&name).is_some() => {
            let message = format!("{source} is a `{}` job", asked.forms.kind(&name).unwrap_or_default());
            scope.error(&code::PREDICTION, place, message, "a `discrepancy` job, or standard deviations by quantity");
            return Added::Nothing;
        }
        None => {
            let of_kind = jobs.iter().filter(|job| job.spec.kind() == discrepancy::Kind::NAME);
            let names: Vec<&str> = of_kind.map(|job| job.name.as_str()).collect();
            scope.unknown(&code::PREDICTION, "discrepancy job", &name, place, &names);
            return Added::Nothing;
        }
    };
    let Some(known) = known else {
        let reason = format!("it adds the discrepancy of {source}, whose data are not here");
        return Added::NotYet(JobSpec::NotYet { kind: Kind::NAME, reason });
    };
    if prediction.posterior.from.as_ref() != Some(&known.calibration) {
        let message = format!("{source} has the residuals of {}", known.source);
        let expected = format!("a discrepancy after {}, whose posterior is carried", prediction.posterior.draws.source);
        scope.error(&code::PREDICTION, place, message, &expected);
        return Added::Nothing;
    }
    let mut sensors = Vec::new();
    for sensor in &known.sensors {
        let of = |&index: &usize| measurements[index].sensors.iter().find(|own| own.name == *sensor);
        let Some(quantity) = known.data.iter().find_map(of).map(|own| own.quantity) else { continue };
        let measured = model.unwrap_or(&scope.resolved.model).quantities[quantity].name.clone();
        let value = match (scope.resolved.quantity(&measured), scope.resolved.node(&measured)) {
            (Some(index), _) => scope.resolved.model.quantities[index].value,
            (None, Some(node)) => {
                let symbol = Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX));
                QuantityValue::Instant(scope.resolved.model.graph.symbol(symbol))
            }
            (None, None) => continue,
        };
        let quantities = &prediction.propagate.quantities;
        let same = |&position: &usize| scope.resolved.model.quantities[quantities[position]].value == value;
        let positions: Vec<usize> = (0..quantities.len()).filter(same).collect();
        if !positions.is_empty() {
            sensors.push((sensor.clone(), positions));
        }
    }
    if sensors.is_empty() {
        let message = format!("no quantity of this prediction is measured by a sensor of {source}");
        scope.error(&code::PREDICTION, place, message, "a quantity that one of its sensors measures");
        return Added::Nothing;
    }
    let from = Upstream { file, job: name };
    let blocked = model.and_then(|_| asked.upstreams.passes.iter().find(|pass| pass.file == from.file));
    let blocked = blocked.and_then(|pass| blocked_job(pass, &from.job));
    Added::Known(run::Added { from, source, blocked, sensors })
}

fn of_this_pass(file: &str, job: &str, place: &Place) -> PosteriorReference {
    PosteriorReference {
        draws: PosteriorPrior {
            source: format!("`{job}`"),
            parameters: Vec::new(),
            names: Vec::new(),
            sha256: None,
            draws: Vec::new(),
            effective: 0.0,
            converged: true,
        },
        from: Some(Upstream { file: file.to_owned(), job: job.to_owned() }),
        blocked: None,
        behind: Vec::new(),
        place: place.clone(),
    }
}

/// The calibration of this pass that is meant, and where it is asked for.
fn own_calibration(
    scope: &mut Scope,
    entry: &Entry,
    written: Option<(&str, &Place)>,
    forms: &Forms,
) -> Option<(String, Place)> {
    let calibrations = forms.of_kind(CALIBRATION);
    match written {
        Some((name, place)) if calibrations.contains(&name) => Some((name.to_owned(), place.clone())),
        Some((name, place)) => {
            match forms.kind(name) {
                Some(other) => {
                    let message = format!("`{name}` is a `{other}` job");
                    scope.error(&code::PREDICTION, place, message, "a `calibrate` job");
                }
                None => scope.unknown(&code::PREDICTION, "calibration", name, place, &calibrations),
            }
            None
        }
        None => match calibrations.as_slice() {
            [only] => Some(((*only).to_owned(), entry.name_place.clone())),
            several => {
                let count = several.len();
                let message =
                    format!("`{}` does not say `from` which calibration, and the pass has {count}", entry.name);
                let expected = match several {
                    [] => "\"from\": {\"pass\": \"pass-1.json\", \"job\": ...}".to_owned(),
                    several => format!("\"from\": one of {}", several.join(", ")),
                };
                scope.error(&code::PREDICTION, &entry.name_place, message, &expected);
                None
            }
        },
    }
}

/// Finds the calibration's parameters in this model. Those that it lacks, such as an effect that was not adopted here, are
/// averaged over.
fn assemble(scope: &Scope, source: Source<'_>, propagate: propagate::Spec) -> Prediction {
    let here = |position: usize| scope.resolved.parameter(&source.parameters[position]);
    let mut posterior = source.posterior;
    let mut priors = Vec::new();
    for &position in source.inference.parameters {
        if let Some(index) = here(position) {
            posterior.draws.parameters.push(index);
            posterior.draws.names.push(source.parameters[position].clone());
            priors.push((index, source.priors[position]));
        }
    }
    let mut posterior_priors = Vec::new();
    for reference in source.posterior_priors {
        let kept: Vec<usize> = (0..reference.draws.parameters.len())
            .filter(|&place| {
                let position = reference.draws.parameters[place];
                source.inference.parameters.contains(&position) && here(position).is_some()
            })
            .collect();
        if kept.is_empty() {
            continue;
        }
        let mut kept_reference = reference.clone();
        kept_reference.draws = kept_reference.draws.with(&kept);
        let indices = kept_reference.draws.parameters.iter().filter_map(|&position| here(position)).collect();
        kept_reference.draws.parameters = indices;
        posterior_priors.push(kept_reference);
    }
    Prediction { propagate, posterior, priors, posterior_priors, discrepancy: Vec::new(), added: None }
}
