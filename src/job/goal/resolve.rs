//! Goal setting: settings with their defaults, names looked up.

use super::Spec;
use super::form::GoalForm;
use crate::document::{Amount, Map, Sense, Spanned, code, counted};
use crate::job::propagate::Discrepancy;
use crate::study::job::Entry;
use crate::study::resolve::chosen::parameters;
use crate::study::resolve::design_variable::design_variable;
use crate::study::resolve::scope::{Scope, unit_of};
use crate::study::resolve::settings::{Offered, environments, failure_limit, requirements, samples};

/// Fewest samples: with fewer no main effect can be distinguished, and so no parameter that leads.
const FEWEST_SAMPLES: u64 = 1024;

/// Resolves the settings of goal setting.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &GoalForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let requirements = requirements(scope, form.requirements.as_ref(), offered);
    if requirements.is_empty() && !scope.diagnostics.has_errors() {
        let message = format!("`{}` has no requirement to set a goal for", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "at least one entry under `requirements`");
    }
    let environments = environments(scope, form.environments.as_ref(), offered);
    let parameters = parameters(scope, form.parameters.as_deref().unwrap_or_default(), offered.priors);
    let names_one = form.design_variable.is_some() || offered.design.iter().count() == 1;
    let design = if names_one { design_variable(scope, entry, form.design_variable.as_ref(), offered) } else { None };
    let samples = samples(scope, form.samples.as_ref(), true);
    if let Some(written) = form.samples.as_ref().filter(|written| written.value < FEWEST_SAMPLES) {
        let message = format!("{}: too few to tell main effects", counted(written.value, "sample"));
        scope.error(&code::JOB_SETTING, &written.place, message, "an integer from 1024 on");
    }
    let failure_limit = failure_limit(scope, form.failure_limit.as_ref());
    let discrepancy = discrepancies(scope, &form.discrepancy);
    let spec = Spec { requirements, environments, parameters, design, samples, discrepancy, failure_limit };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// Standard deviations of the model's errors, by quantity.
pub fn discrepancies(scope: &mut Scope, written: &Map<Amount>) -> Vec<Discrepancy> {
    let mut discrepancy = Vec::new();
    for model_error in written {
        let name = Spanned { value: model_error.name.clone(), place: model_error.name_place.clone() };
        let Some(quantity) = scope.quantity(&name) else { continue };
        let unit = unit_of(&scope.resolved.model.quantities[quantity].unit);
        let Some(sd) = model_error.value.si(unit.dimension, None, Sense::Difference, scope.diagnostics) else {
            continue;
        };
        if !(sd >= 0.0 && sd.is_finite()) {
            let message = format!("a discrepancy of {sd}");
            scope.error(&code::JOB_SETTING, &model_error.place, message, "a standard deviation, 0 or above");
        }
        discrepancy.push(Discrepancy { quantity, sd });
    }
    discrepancy
}
