//! What a pass changes in the model's parameters.

use crate::document::prior::support;
use crate::document::{Diagnostic, Map, Sense, code};
use crate::expression::Dimension;
use crate::random::Distribution;
use crate::study::model::Prior;
use crate::study::pass::ParameterChangeForm;
use crate::study::resolved::ParameterChange;

use super::scope::Scope;

/// Applies the changes and gives them, and the priors of all parameters in SI; one from draws is no more than a placeholder yet.
pub fn changes(scope: &mut Scope, forms: &Map<ParameterChangeForm>) -> (Vec<ParameterChange>, Vec<Distribution>) {
    // Priors first, so that a change can say what was before; those that a pass replaces need not be usable.
    let mut priors: Vec<Option<Distribution>> =
        scope.resolved.priors.iter().map(|prior| prior.distribution().copied()).collect();
    let mut changes = Vec::new();
    for entry in forms {
        let Some(index) = scope.resolved.parameter(&entry.name) else {
            let parameter_names: Vec<String> =
                scope.resolved.model.parameters.iter().map(|parameter| parameter.name.clone()).collect();
            let parameter_names: Vec<&str> = parameter_names.iter().map(String::as_str).collect();
            scope.unknown(&code::UNKNOWN_NAME, "parameter", &entry.name, &entry.name_place, &parameter_names);
            continue;
        };
        let form = &entry.value;
        match &form.because {
            Some(because) => {
                scope.reason(because);
            }
            None if form.prior.is_some() || form.nominal.is_some() => {
                let message = format!("`{}` is changed without a reason", entry.name);
                scope.error(&code::BECAUSE_MISSING, &entry.name_place, message, "\"because\": \"...\"");
            }
            None => {}
        }
        let scale = scope.resolved.parameter_scales[index].clone();
        let dimension = scale.dimension().unwrap_or(Dimension::NONE);
        let before = scope.resolved.model.parameters[index].nominal;
        let nominal = match &form.nominal {
            Some(amount) => scale.si(amount, Sense::Absolute, scope.diagnostics).unwrap_or(before),
            None => before,
        };
        let old = priors[index];
        if let Some(prior) = &form.prior {
            let new = prior.resolve(scale.unit.as_ref(), dimension, Sense::Absolute, scope.diagnostics);
            if let Some(new) = new {
                priors[index] = new.distribution().copied();
                scope.resolved.priors[index] = new;
            }
        } else if let (Some(Distribution::Fixed(_)), true) = (old, form.nominal.is_some()) {
            // A parameter that is known is known at its nominal value.
            priors[index] = Some(Distribution::Fixed(nominal));
            scope.resolved.priors[index] = Prior::Distribution(Distribution::Fixed(nominal));
        }
        if let Some([lower, upper]) = priors[index].as_ref().map(support)
            && (nominal < lower || nominal > upper)
        {
            let message = format!("the nominal value of `{}` lies outside its prior", entry.name);
            let place = form.nominal.as_ref().map_or(&entry.name_place, |amount| &amount.place);
            scope
                .diagnostics
                .push(Diagnostic::warning(&code::NOMINAL_OUTSIDE, place, message).expected("a value within the prior"));
        }
        let parameter = &mut scope.resolved.model.parameters[index];
        parameter.nominal = nominal;
        if let Some(description) = &form.description {
            parameter.description.clone_from(description);
        }
        if let Some(source) = &form.source {
            parameter.source.clone_from(source);
        }
        let fixed = Distribution::Fixed(nominal);
        changes.push(ParameterChange {
            name: entry.name.clone(),
            unit: parameter.unit.clone(),
            nominal: [before, nominal],
            prior: [old.unwrap_or(fixed), priors[index].unwrap_or(fixed)],
            draws: scope.resolved.priors[index].draws_words(),
            because: form.because.as_ref().map_or_else(String::new, |because| because.value.clone()),
        });
    }
    // What draws stand in for is looked up when all parameters are known.
    let usable = priors.iter().map(|prior| prior.unwrap_or(Distribution::Fixed(0.0))).collect();
    (changes, usable)
}
