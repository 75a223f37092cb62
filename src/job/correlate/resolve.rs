//! Correlations: settings with their defaults, names looked up.

use super::form::{CorrelateForm, MethodForm};
use super::{Free, Kind, Method, Spec};
use crate::document::code;
use crate::job::kind::JobKind;
use crate::job::prior_ends::ends;
use crate::study::job::{Entry, JobSpec};
use crate::study::profile;
use crate::study::resolve::chosen::{data, parameters_or_all};
use crate::study::resolve::design_variable::design_range;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::Offered;
use crate::study::variable::Variable;

/// Resolves the settings of a correlation.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &CorrelateForm, offered: &Offered) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "correlate with", offered);
    let name = form.criteria.as_ref().map_or(profile::DEFAULT, |name| name.value.as_str());
    let criteria = offered.profiles.iter().find(|profile| profile.name == name).cloned();
    match (&criteria, &form.criteria) {
        (None, Some(written)) => {
            let names: Vec<&str> = offered.profiles.iter().map(|profile| profile.name.as_str()).collect();
            scope.unknown(&code::JOB_REFERENCE, "criteria profile", name, &written.place, &names);
        }
        (Some(criteria), _) if criteria.each_k.or(criteria.mean_k).or(criteria.sd_k).is_none() => {
            let message = format!("the profile `{name}` demands nothing of deviations");
            let place = form.criteria.as_ref().map_or(&entry.name_place, |written| &written.place);
            scope.error(&code::JOB_REFERENCE, place, message, "a profile with `each`, `mean` or `sd`");
        }
        _ => {}
    }
    let chosen = parameters_or_all(scope, form.parameters.as_ref(), offered.priors);
    let mut free: Vec<Free> = chosen.iter().map(|&index| Free { index, range: ends(&offered.priors[index]) }).collect();
    for range in &form.ranges {
        let Some(sweep) = design_range(scope, range) else { continue };
        let own = free.iter_mut().find(|own| sweep.variable == Variable::Parameter(own.index));
        match (own, sweep.values.as_slice()) {
            (Some(own), [from, to]) => own.range = [from.min(*to), from.max(*to)],
            _ => {
                let message = format!("`{}` is not changed by this correlation", range.name);
                scope.error(&code::JOB_REFERENCE, &range.name_place, message, "one of its `parameters`");
            }
        }
    }
    for own in &free {
        let parameter = &scope.resolved.model.parameters[own.index];
        let (name, nominal, unit) = (parameter.name.clone(), parameter.nominal, parameter.unit.clone());
        if !(own.range[0] <= nominal && nominal <= own.range[1]) {
            let message = format!(
                "`{name}` begins at {nominal} and may be changed between {} and {} (SI, written in {unit})",
                own.range[0], own.range[1]
            );
            let expected =
                format!("\"ranges\": {{\"{name}\": {{\"from\": ..., \"to\": ...}}}} round its nominal value");
            scope.error(&code::JOB_SETTING, &entry.name_place, message, &expected);
        }
    }
    if free.is_empty() && scope.diagnostics.errors() == before {
        let message = format!("`{}` has no parameter to change", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "`parameters` with priors that are not fixed");
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        return Some(JobSpec::Waiting { kind: Kind::NAME, measurements: missing, command: offered.command.clone() });
    }
    let method = match form.method {
        Some(MethodForm::LeastSquares) => Method::LeastSquares,
        Some(MethodForm::OneAtATime) | None => Method::OneAtATime,
    };
    Some(JobSpec::of(Spec { data, parameters: free, criteria: criteria?, method }))
}
