//! Calibrations: settings with their defaults, names looked up.

use super::form::CalibrateForm;
use super::{Sampler, Spec, is_long};
use crate::document::{Spanned, code};
use crate::study::job::{Entry, JobSpec};
use crate::study::resolve::chosen::{data, parameters_or_all};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{Offered, number};
use crate::thermal::Derivatives;

/// Chains where a job says nothing.
const CHAINS: u64 = 4;
/// Most chains.
const MOST_CHAINS: u64 = 64;
/// Most steps or draws of a chain.
const MOST_DRAWS: u64 = 1_000_000;

/// Resolves the settings of a calibration.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &CalibrateForm, offered: &Offered) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "calibrate on", offered);
    let parameters = parameters_or_all(scope, form.parameters.as_ref(), offered.priors);
    let usual = match scope.resolved.derivatives() {
        // Only trajectories aim at an acceptance.
        None | Some(Derivatives::Served)
            if form.acceptance.is_none() && is_long(data.iter().filter_map(|&at| offered.data.get(at))) =>
        {
            Sampler::IndependenceMetropolis
        }
        None | Some(Derivatives::Served) => Sampler::Nuts,
        // Trajectories would ask for many differences.
        Some(_) => Sampler::AdaptiveMetropolis,
    };
    let sampler = form.sampler.unwrap_or(usual);
    let method = sampler.method();
    let (warmup, draws) = sampler.defaults();
    if let (false, Some(warmup)) = (method.has_warm_up(), &form.warmup) {
        let message = format!("`{}` has no warm-up", sampler.name());
        scope.error(&code::JOB_SETTING, &warmup.place, message, "leave it out");
    }
    let chains = number(scope, form.chains.as_ref(), CHAINS, 2, MOST_CHAINS, "chains");
    let draws = number(scope, form.draws.as_ref(), draws, method.least_draws(), MOST_DRAWS, "draws of a chain");
    let warmup = number(scope, form.warmup.as_ref(), warmup, 0, MOST_DRAWS, "steps of warm-up");
    let acceptance = form.acceptance.as_ref().map(|written| acceptance(scope, written, sampler));
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        let command = offered.command.clone();
        return Some(JobSpec::Waiting { kind: "calibrate", measurements: missing, command });
    }
    Some(JobSpec::of(Spec { data, parameters, sampler, chains, warmup, draws, acceptance }))
}

/// The acceptance that trajectories aim at.
fn acceptance(scope: &mut Scope, written: &Spanned<f64>, sampler: Sampler) -> f64 {
    if !sampler.method().has_acceptance() {
        let message = format!("`{}` aims at no acceptance", sampler.name());
        scope.error(&code::JOB_SETTING, &written.place, message, "leave it out");
    } else if !(0.5..=0.999).contains(&written.value) {
        let message = format!("an acceptance of {}", written.value);
        scope.error(&code::JOB_SETTING, &written.place, message, "a number from 0.5 to 0.999");
    }
    written.value
}
