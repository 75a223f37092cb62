//! Parameters of an adopted effect: the catalogue's, with what the pass says otherwise.

use crate::document::prior::support;
use crate::document::quantity::report_dimension;
use crate::document::{Diagnostic, MapEntry, Prior, code, suggest};
use crate::effect::{Bound, Effect, EffectParameter};
use crate::study::pass::adopt::{EffectParameter as EffectParameterForm, EffectUse};

use super::scope::Scope;

/// The parameters of an effect where its inputs stand for `bound`. `None` after an error.
pub fn parameters(
    scope: &mut Scope,
    effect: &Effect,
    usage: &EffectUse,
    bound: &[Bound],
) -> Option<Vec<EffectParameter>> {
    let before = scope.diagnostics.errors();
    let mut parameters = effect.parameters(&scope.resolved.model, bound);
    for entry in &usage.parameters {
        // A curve's knots are named together or one by one.
        let named = |parameter: &EffectParameter| parameter.name == entry.name || parameter.written == entry.name;
        if !parameters.iter().any(&named) {
            let parameter_names: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
            let parameter_names: Vec<&str> = parameter_names.iter().map(String::as_str).collect();
            let message = format!("`{}` has no parameter `{}`", effect.name, entry.name);
            let listed = suggest::listed(parameter_names.iter().copied(), 12);
            scope.error(&code::EFFECT_PARAMETER, &entry.name_place, message, &listed);
            continue;
        }
        for parameter in parameters.iter_mut().filter(|parameter| named(parameter)) {
            change(scope, parameter, entry);
        }
    }
    (scope.diagnostics.errors() == before).then_some(parameters)
}

fn change(scope: &mut Scope, parameter: &mut EffectParameter, entry: &MapEntry<EffectParameterForm>) {
    let form = &entry.value;
    let dimension = parameter.unit.dimension;
    if let Some(written) = &form.unit {
        if written.unit.dimension != dimension {
            report_dimension(&written.unit, &written.place, dimension, scope.diagnostics);
            return;
        }
        parameter.unit = written.unit.clone();
    }
    if let Some(description) = &form.description {
        parameter.description.clone_from(description);
    }
    let unit = parameter.unit.clone();
    if let Some(prior) = &form.prior {
        match prior.resolve(Some(&unit), dimension, parameter.sense, scope.diagnostics) {
            Some(Prior::Distribution(distribution)) => {
                let [lower, upper] = support(&distribution);
                if !parameter.sign.allows(lower) || !parameter.sign.allows(upper) {
                    let message = format!("the prior of `{}` reaches values that are not physical", entry.name);
                    let expected = match parameter.sign.word() {
                        "positive" => "a prior on values of 0 and more",
                        _ => "a prior on values of 0 and less",
                    };
                    scope.error(&code::EFFECT_PARAMETER, &entry.place, message, expected);
                    return;
                }
                parameter.prior = distribution;
                parameter.nominal = distribution.quantile(0.5);
            }
            Some(drawn) => scope.drawn.push((parameter.name.clone(), drawn)),
            None => {}
        }
    }
    if let Some(amount) = &form.nominal
        && let Some(nominal) = amount.si(dimension, Some(&unit), parameter.sense, scope.diagnostics)
    {
        let [lower, upper] = support(&parameter.prior);
        if nominal < lower || nominal > upper {
            let message = format!("the nominal value of `{}` lies outside its prior", entry.name);
            scope.diagnostics.push(
                Diagnostic::warning(&code::NOMINAL_OUTSIDE, &amount.place, message)
                    .expected("a value within the prior"),
            );
        }
        parameter.nominal = nominal;
    }
}
