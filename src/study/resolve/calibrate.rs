//! Calibrations: settings with their defaults, names looked up; and which comparisons show their result.

use crate::document::{Map, MapEntry, Spanned, code};
use crate::job::calibrate::{Sampler, Spec};
use crate::study::pass::job::{CalibrateForm, JobForm, SamplerForm};
use crate::study::resolved::{JobSpec, NamedJob};

use super::chosen::{data, parameters_or_all};
use super::jobs::Offered;
use super::scope::Scope;

/// Chains where a job says nothing.
const CHAINS: u64 = 4;
/// Most chains.
const MOST_CHAINS: u64 = 64;
/// Most steps or draws of a chain.
const MOST_DRAWS: u64 = 1_000_000;

/// Resolves the settings of a calibration.
pub(super) fn calibrate(
    scope: &mut Scope,
    entry: &MapEntry<JobForm>,
    form: &CalibrateForm,
    offered: &Offered,
) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "calibrate on", offered);
    let parameters = parameters_or_all(scope, form.parameters.as_ref(), offered.priors);
    let sampler = match form.sampler {
        None | Some(SamplerForm::Nuts) => Sampler::Nuts,
        Some(SamplerForm::AdaptiveMetropolis) => Sampler::AdaptiveMetropolis,
        Some(SamplerForm::Smc) => Sampler::Smc,
    };
    let (warmup, draws) = sampler.defaults();
    if let (Sampler::Smc, Some(warmup)) = (sampler, &form.warmup) {
        let message = "`smc` has no warm-up".to_owned();
        scope.error(&code::JOB_SETTING, &warmup.place, message, "leave it out");
    }
    let chains = number(scope, form.chains.as_ref(), CHAINS, 2, MOST_CHAINS, "chains");
    let least = if sampler == Sampler::Smc { 16 } else { 4 };
    let draws = number(scope, form.draws.as_ref(), draws, least, MOST_DRAWS, "draws of a chain");
    let warmup = number(scope, form.warmup.as_ref(), warmup, 0, MOST_DRAWS, "steps of warm-up");
    let acceptance = form.acceptance.as_ref().map(|written| acceptance(scope, written, sampler));
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        let command = offered.command.clone();
        return Some(JobSpec::Waiting { kind: "calibrate", measurements: missing, command });
    }
    Some(JobSpec::Calibrate(Spec { data, parameters, sampler, chains, warmup, draws, acceptance }))
}

/// The acceptance that trajectories aim at.
fn acceptance(scope: &mut Scope, written: &Spanned<f64>, sampler: Sampler) -> f64 {
    if sampler != Sampler::Nuts {
        let message = format!("`{}` aims at no acceptance", sampler.name());
        scope.error(&code::JOB_SETTING, &written.place, message, "leave it out");
    } else if !(0.5..=0.999).contains(&written.value) {
        let message = format!("an acceptance of {}", written.value);
        scope.error(&code::JOB_SETTING, &written.place, message, "a number from 0.5 to 0.999");
    }
    written.value
}

pub(super) fn number(
    scope: &mut Scope,
    written: Option<&Spanned<u64>>,
    default: u64,
    least: u64,
    most: u64,
    what: &str,
) -> u64 {
    let Some(Spanned { value, place }) = written else { return default };
    if !(least..=most).contains(value) {
        let expected = format!("an integer from {least} to {most}");
        scope.error(&code::JOB_SETTING, place, format!("{value} {what}"), &expected);
    }
    *value
}

/// Lets comparisons that say nothing of `from` show the first calibration whose data they all have.
pub(super) fn show_in_comparisons(jobs: &mut [NamedJob], forms: &Map<JobForm>) {
    let calibrations: Vec<(String, Vec<usize>)> = jobs
        .iter()
        .filter_map(|job| match &job.spec {
            JobSpec::Calibrate(spec) => Some((job.name.clone(), spec.data.clone())),
            _ => None,
        })
        .collect();
    for job in jobs {
        let JobSpec::Compare(spec) = &mut job.spec else { continue };
        let form = forms.get(&job.name).map(|entry| &entry.value);
        let says = matches!(form, Some(JobForm::Compare(form)) if form.from.is_some());
        if !says {
            let found = calibrations.iter().find(|(_, data)| data.iter().all(|index| spec.data.contains(index)));
            spec.calibration = found.map(|(name, _)| name.clone());
        }
    }
}
