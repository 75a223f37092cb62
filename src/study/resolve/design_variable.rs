//! Design variables: the values of a sweep, the range in which one is sought.

use crate::document::prior::support;
use crate::document::{Amount, Map, MapEntry, NameOr, Sense, Spanned, code, counted};
use crate::study::job::Entry;
use crate::study::model::Scale;
use crate::study::pass::variable::{RangeForm, SweepForm};
use crate::study::variable::{Sweep, Variable};

use super::scope::Scope;
use super::settings::Offered;

/// Most values of a sweep.
const MOST_STEPS: usize = 10_000;

/// A design variable's values in SI; bare numbers are in its own unit.
fn value(scope: &mut Scope, amount: &Amount, scale: &Scale) -> Option<f64> {
    scale.si(amount, Sense::Absolute, scope.diagnostics)
}

/// Equally spaced values, both ends exact; at least two.
pub fn spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    (0..count)
        .map(|index| {
            let share = index as f64 / last;
            from * (1.0 - share) + to * share
        })
        .collect()
}

/// The values of a sweep of one parameter or input.
pub fn sweep(scope: &mut Scope, form: &Spanned<Map<SweepForm>>) -> Option<Sweep> {
    let entry = match form.value.iter().collect::<Vec<_>>().as_slice() {
        [one] => *one,
        several => {
            let message = format!("a sweep of {} variables", several.len());
            scope.error(&code::SWEEP, &form.place, message, "exactly one parameter or input");
            return None;
        }
    };
    let (variable, scale) = scope.variable(&entry.name, &entry.name_place)?;
    let values: Vec<f64> = match &entry.value {
        SweepForm::List(list) => {
            let values: Vec<Option<f64>> = list.iter().map(|amount| value(scope, amount, &scale)).collect();
            values.into_iter().collect::<Option<_>>()?
        }
        SweepForm::Steps(steps) => {
            let (from, to) = (value(scope, &steps.from, &scale)?, value(scope, &steps.to, &scale)?);
            let count = steps.steps.value;
            if !(2..=MOST_STEPS).contains(&count) {
                let message = format!("a sweep of {}", counted(count, "step"));
                scope.error(&code::SWEEP, &steps.steps.place, message, &format!("from 2 to {MOST_STEPS} values"));
                return None;
            }
            spaced(from, to, count)
        }
    };
    let rises = values.windows(2).all(|pair| pair[0] < pair[1]);
    let falls = values.windows(2).all(|pair| pair[0] > pair[1]);
    if values.is_empty() || values.len() > MOST_STEPS || !(rises || falls) {
        scope.error(
            &code::SWEEP,
            &entry.place,
            "the values of a sweep are not in order",
            "at least one value, each above the one before, or each below it",
        );
        return None;
    }
    Some(Sweep { name: entry.name.clone(), unit: scale.text().to_owned(), variable, values })
}

/// What is sized, with the ends of its range.
pub fn design_variable(
    scope: &mut Scope,
    entry: &Entry,
    written: Option<&NameOr<Spanned<Map<RangeForm>>>>,
    offered: &Offered,
) -> Option<Sweep> {
    match written {
        Some(NameOr::Other(map)) => match map.value.iter().collect::<Vec<_>>().as_slice() {
            [one] => design_range(scope, one),
            several => {
                let message = format!("{} design variables", several.len());
                scope.error(&code::SWEEP, &map.place, message, "exactly one parameter or input");
                None
            }
        },
        Some(NameOr::Name(name)) => match offered.design.get(&name.value) {
            Some(range) => design_range(scope, range),
            None => known_range(scope, name, offered),
        },
        None => match offered.design.iter().collect::<Vec<_>>().as_slice() {
            [one] => design_range(scope, one),
            several => {
                let message = format!("`{}` names no design variable, and the pass has {}", entry.name, several.len());
                let expected = "\"design_variable\": {NAME: {\"from\": ..., \"to\": ...}}";
                scope.error(&code::SWEEP, &entry.name_place, message, expected);
                None
            }
        },
    }
}

/// A design variable with the ends of its range as written.
pub fn design_range(scope: &mut Scope, entry: &MapEntry<RangeForm>) -> Option<Sweep> {
    let (variable, scale) = scope.variable(&entry.name, &entry.name_place)?;
    let from = value(scope, &entry.value.from, &scale);
    let to = value(scope, &entry.value.to, &scale);
    let (from, to) = (from?, to?);
    if from == to || !from.is_finite() || !to.is_finite() {
        let message = format!("the range of `{}` is empty", entry.name);
        scope.error(&code::SWEEP, &entry.place, message, "two values; rules pass towards `to`");
        return None;
    }
    Some(Sweep { name: entry.name.clone(), unit: scale.text().to_owned(), variable, values: vec![from, to] })
}

/// The range of an input, or of a bounded prior.
fn known_range(scope: &mut Scope, name: &Spanned<String>, offered: &Offered) -> Option<Sweep> {
    let (variable, scale) = scope.variable(&name.value, &name.place)?;
    let range = match variable {
        Variable::Input(index) => scope.resolved.model.inputs[index].range,
        Variable::Parameter(index) => Some(support(&offered.priors[index])),
    };
    match range.filter(|[from, to]| from < to && from.is_finite() && to.is_finite()) {
        Some(range) => {
            Some(Sweep { name: name.value.clone(), unit: scale.text().to_owned(), variable, values: range.to_vec() })
        }
        None => {
            let message = format!("no range is known in which `{}` could be sought", name.value);
            let expected = format!("{{\"{}\": {{\"from\": ..., \"to\": ...}}}}", name.value);
            scope.error(&code::SWEEP, &name.place, message, &expected);
            None
        }
    }
}
