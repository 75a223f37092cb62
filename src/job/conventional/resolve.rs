//! The conventional way: settings with their defaults, names looked up.

use super::form::ConventionalForm;
use super::output::{Knowledge, Spec};
use crate::document::{Diagnostic, Place, Spanned, code};
use crate::expression::Dimension;
use crate::study::job::{Asked, Entry, Forms};
use crate::study::model::Scale;
use crate::study::requirement::Requirement;
use crate::study::resolve::design_variable::design_variable;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{environments, requirements};
use crate::study::rule::{Margin, Rule};
use crate::study::variable::Variable;

/// Resolves the settings of a conventional analysis.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &ConventionalForm, asked: &mut Asked) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let correlation = form.from.as_ref().and_then(|from| correlation(scope, from, asked.forms));
    let knowledge = form.priors_of.as_ref().and_then(|file| knowledge(scope, file, asked));
    let offered = asked.offered;
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
    applicable(scope, entry, form, &rules, &requirements, heat_loads.is_empty());
    let design = design?;
    let spec = Spec { rules, environments, requirements, design, heat_loads, correlation, knowledge };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// Refuses rules that say nothing of a requirement: kelvins of a quantity in another unit, a share of heat loads where there
/// are none.
fn applicable(
    scope: &mut Scope,
    entry: &Entry,
    form: &ConventionalForm,
    rules: &[Rule],
    requirements: &[Requirement],
    has_no_load: bool,
) {
    for rule in rules {
        let named = form.rules.iter().flatten().find(|name| name.value == rule.name);
        let place = named.map_or(&entry.name_place, |name| &name.place);
        match rule.margin {
            Margin::TemperatureK(margin) if margin != 0.0 => {
                let dimensions = &scope.resolved.quantity_dimensions;
                let unit_of =
                    |own: &Requirement| dimensions.get(own.quantity).copied().unwrap_or(Dimension::TEMPERATURE);
                let is_other = |own: &&Requirement| unit_of(own) != Dimension::TEMPERATURE;
                let Some(other) = requirements.iter().find(is_other) else {
                    narrow_bands(scope, place, &rule.name, margin, requirements);
                    continue;
                };
                let unit = unit_of(other);
                let message = format!(
                    "the rule `{}` is a margin of temperature, and the requirement `{}` is about a quantity in {unit}",
                    rule.name, other.name
                );
                let expected = "`requirements` about temperatures, or `rules` without margins of temperature";
                scope.error(&code::JOB_REFERENCE, place, message, expected);
                return;
            }
            Margin::HeatLoad(_) if has_no_load && named.is_some() => {
                let message = format!("the rule `{}` changes heat loads, and no parameter or input is in W", rule.name);
                let expected = "`heat_loads`, or `rules` without it";
                scope.error(&code::JOB_REFERENCE, place, message, expected);
            }
            Margin::TemperatureK(_) | Margin::HeatLoad(_) => {}
        }
    }
}

/// Warns of requirements on both sides whose limits lie too near one another for a margin at each: no design passes.
fn narrow_bands(scope: &mut Scope, place: &Place, rule: &str, margin: f64, requirements: &[Requirement]) {
    for own in requirements {
        let Some((below, above)) = own.below.zip(own.above) else { continue };
        let width = below - above;
        if width < 2.0 * margin {
            let message = format!(
                "no design passes the rule `{rule}` for the requirement `{}`: its limits lie {width:.4} K apart, and {margin} K are \
                 asked for at each",
                own.name
            );
            let help = "size for the side that governs: a requirement with `below` alone, or with `above` alone";
            scope.diagnostics.push(Diagnostic::warning(&code::JOB_REFERENCE, place, message).help(help));
        }
    }
}

/// Kind of the jobs whose values may stand.
const CORRELATION: &str = "correlate";

/// The correlation of this pass that is meant.
fn correlation(scope: &mut Scope, from: &Spanned<String>, forms: &Forms) -> Option<String> {
    match forms.kind(&from.value) {
        Some(CORRELATION) => return Some(from.value.clone()),
        Some(other) => {
            let message = format!("`{}` is a `{other}` job", from.value);
            scope.error(&code::JOB_REFERENCE, &from.place, message, "a `correlate` job");
        }
        None => {
            let names = forms.of_kind(CORRELATION);
            scope.unknown(&code::JOB_REFERENCE, "correlation", &from.value, &from.place, &names);
        }
    }
    None
}

/// What an earlier pass knew of this model's parameters.
fn knowledge(scope: &mut Scope, file: &Spanned<String>, asked: &mut Asked) -> Option<Knowledge> {
    let pass = asked.upstreams.pass(scope, &file.value, &file.place)?;
    if !pass.posterior_priors.is_empty() {
        let message = format!("priors of `{}` are draws of a calibration", pass.file);
        scope.error(&code::JOB_REFERENCE, &file.place, message, "a pass before any calibration was handed on");
        return None;
    }
    let own = pass.model.parameters.iter().zip(&pass.priors);
    let parameters = own
        .filter_map(|(parameter, prior)| Some((scope.resolved.parameter(&parameter.name)?, parameter.nominal, *prior)));
    Some(Knowledge { pass: pass.file.clone(), parameters: parameters.collect() })
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
