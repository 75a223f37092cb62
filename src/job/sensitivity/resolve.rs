//! Sensitivity analyses: settings with their defaults, names looked up.

use super::form::{MethodForm, SensitivityForm};
use super::{Method, Spec};
use crate::document::{Spanned, code};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{Offered, environments, failure_limit, number, quantities, samples};
use crate::thermal::Derivatives;

/// Scrambles where a job says nothing.
const SCRAMBLES: u64 = 8;
/// Most scrambles.
const MOST_SCRAMBLES: u64 = 64;
/// Trajectories where a job says nothing.
const TRAJECTORIES: u64 = 64;
/// Most trajectories.
const MOST_TRAJECTORIES: u64 = 1 << 20;

/// Resolves the settings of a sensitivity analysis.
pub(super) fn resolve(scope: &mut Scope, form: &SensitivityForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let environments = environments(scope, form.environments.as_ref(), offered);
    // What is asked for by name is all that is asked for.
    let requirements = if form.quantities.is_some() { &[] } else { offered.requirements };
    let quantities = quantities(scope, form.quantities.as_ref(), requirements, offered);
    let methods = match &form.methods {
        None if scope.resolved.derivatives() == Some(Derivatives::UsualSteps) => {
            vec![Method::Morris, Method::Sobol]
        }
        None => vec![Method::Local, Method::Morris, Method::Sobol, Method::Derivative],
        Some(forms) => {
            let mut methods = Vec::new();
            for form in forms {
                let method = match form {
                    MethodForm::Local => Method::Local,
                    MethodForm::Morris => Method::Morris,
                    MethodForm::Sobol => Method::Sobol,
                    MethodForm::Derivative => Method::Derivative,
                };
                if !methods.contains(&method) {
                    methods.push(method);
                }
            }
            methods
        }
    };
    let samples = samples(scope, form.samples.as_ref(), true);
    let scrambles = number(scope, form.scrambles.as_ref(), SCRAMBLES, 2, MOST_SCRAMBLES, "scrambles");
    let trajectories = number(scope, form.trajectories.as_ref(), TRAJECTORIES, 2, MOST_TRAJECTORIES, "trajectories");
    if let Some(Spanned { value, place }) = &form.precision
        && !(*value > 0.0 && *value <= 1.0)
    {
        let message = format!("a precision of {value}");
        scope.error(&code::JOB_SETTING, place, message, "the width of an interval, above 0 and at most 1");
    }
    let failure_limit = failure_limit(scope, form.failure_limit.as_ref());
    let spec = Spec {
        quantities,
        methods,
        samples,
        scrambles,
        second_order: form.second_order,
        precision: form.precision.as_ref().map(|precision| precision.value),
        trajectories,
        environments,
        failure_limit,
    };
    (scope.diagnostics.errors() == before).then_some(spec)
}
