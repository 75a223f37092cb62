//! The conventional way: settings with their defaults, names looked up.

use super::Spec;
use super::form::ConventionalForm;
use crate::document::{Spanned, code};
use crate::expression::Dimension;
use crate::study::job::Entry;
use crate::study::model::Scale;
use crate::study::resolve::design_variable::design_variable;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{Offered, environments, requirements};
use crate::study::variable::Variable;

/// Resolves the settings of a conventional analysis.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &ConventionalForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let rules = match &form.rules {
        None => offered.rules.to_vec(),
        Some(names) => {
            let mut rules = Vec::new();
            for name in names {
                match offered.rules.iter().find(|rule| rule.name == name.value) {
                    Some(rule) => rules.push(rule.clone()),
                    None => {
                        let rule_names: Vec<&str> = offered.rules.iter().map(|rule| rule.name.as_str()).collect();
                        scope.unknown(&code::JOB_REFERENCE, "margin rule", &name.value, &name.place, &rule_names);
                    }
                }
            }
            rules
        }
    };
    let environments = environments(scope, form.environments.as_ref(), offered);
    let requirements = requirements(scope, form.requirements.as_ref(), offered);
    if requirements.is_empty() && !scope.diagnostics.has_errors() {
        let message = format!("`{}` has no requirement to size for", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "at least one entry under `requirements`");
    }
    let design = design_variable(scope, entry, form.design_variable.as_ref(), offered);
    let heat_loads = heat_loads(scope, form.heat_loads.as_ref(), design.as_ref().map(|design| design.variable));
    let design = design?;
    let spec = Spec { rules, environments, requirements, design, heat_loads };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// The parameters and inputs that are heat loads: those named, else all in W but the design variable.
fn heat_loads(scope: &mut Scope, names: Option<&Vec<Spanned<String>>>, design: Option<Variable>) -> Vec<Variable> {
    if let Some(names) = names {
        return names.iter().filter_map(|name| Some(scope.variable(&name.value, &name.place)?.0)).collect();
    }
    let is_power = |scale: &Scale| scale.dimension() == Some(Dimension::POWER);
    let parameters = scope.resolved.parameter_scales.iter().enumerate().filter(|(_, scale)| is_power(scale));
    let inputs = scope.resolved.input_scales.iter().enumerate().filter(|(_, scale)| is_power(scale));
    let parameters = parameters.map(|(index, _)| Variable::Parameter(index));
    parameters.chain(inputs.map(|(index, _)| Variable::Input(index))).filter(|load| Some(*load) != design).collect()
}
