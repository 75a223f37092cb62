//! Margins from history: the file read, settings with their defaults.

use super::form::HistoryForm;
use super::output::{Comparison, Spec};
use crate::document::{Sense, Spanned, code, counted};
use crate::expression::Dimension;
use crate::study::job::Entry;
use crate::study::resolve::data::{self, Wanted};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::Offered;
use crate::study::rule::{Margin, Rule};
use crate::study::table::{Cells, separator};

/// Share and confidence where a job says nothing.
const SHARE: f64 = 0.95;
/// Fewest rows: a standard deviation of fewer says next to nothing.
const FEWEST: usize = 5;
/// Within this range shares and confidences are.
const SHARES: [f64; 2] = [0.5, 0.9999];

/// Resolves the settings.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &HistoryForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let capture = share(scope, form.capture.as_ref());
    let confidence = share(scope, form.confidence.as_ref());
    let rules = rules(scope, form.rules.as_ref(), offered);
    let separator = separator(form.separator.as_ref(), scope.diagnostics);
    let data = data::data(scope, &form.file, separator, None).ok()??;
    let wanted = ["predicted", "measured"].map(|name| Wanted {
        name,
        place: &form.file.place,
        dimension: Some(Dimension::TEMPERATURE),
        sense: Sense::Absolute,
        cells: Cells::Numbers,
        required: true,
    });
    let columns = data::numbers(scope, &data, &wanted).ok()?;
    let [predicted, measured] = columns.as_slice() else { return None };
    let classes = data::texts(scope, &data, "class").ok()?;
    let programs = data::texts(scope, &data, "program").ok()?;
    let text = |column: &Option<Vec<String>>, row: usize| -> String {
        column.as_ref().and_then(|texts| texts.get(row)).cloned().unwrap_or_default()
    };
    let comparison = |(row, (predicted, measured)): (usize, (&f64, &f64))| Comparison {
        class: text(&classes, row),
        program: text(&programs, row),
        difference_k: measured - predicted,
    };
    let comparisons: Vec<Comparison> = predicted.iter().zip(measured).enumerate().map(comparison).collect();
    if comparisons.len() < FEWEST {
        let count = counted(comparisons.len(), "comparison");
        let message = format!("`{}` of `{}` has {count}", form.file.value, entry.name);
        scope.error(&code::JOB_SETTING, &form.file.place, message, "5 rows or more: `predicted`, `measured`");
    }
    let spec = Spec {
        file: form.file.value.clone(),
        sha256: data.sha256,
        comparisons,
        has_programs: programs.is_some(),
        capture,
        confidence,
        rules,
    };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// A share or a confidence.
fn share(scope: &mut Scope, written: Option<&Spanned<f64>>) -> f64 {
    let Some(written) = written else { return SHARE };
    if !(SHARES[0]..=SHARES[1]).contains(&written.value) {
        let expected = format!("a share from {} to {}", SHARES[0], SHARES[1]);
        scope.error(&code::JOB_SETTING, &written.place, format!("a share of {}", written.value), &expected);
        return SHARE;
    }
    written.value
}

/// Margins of temperature by rule: those named, else all that are above 0.
fn rules(scope: &mut Scope, names: Option<&Vec<Spanned<String>>>, offered: &Offered) -> Vec<(String, f64)> {
    let margin = |rule: &Rule| match rule.margin {
        Margin::TemperatureK(margin) => Some((rule.name.clone(), margin)),
        Margin::HeatLoad(_) => None,
    };
    let Some(names) = names else {
        return offered.rules.iter().filter_map(margin).filter(|(_, margin)| *margin > 0.0).collect();
    };
    let mut rules = Vec::new();
    for name in names {
        match offered.rules.iter().find(|rule| rule.name == name.value) {
            Some(rule) => match margin(rule) {
                Some(rule) => rules.push(rule),
                None => {
                    let message = format!("the rule `{}` is no margin of temperature", name.value);
                    scope.error(&code::JOB_REFERENCE, &name.place, message, "a rule that moves a limit by kelvins");
                }
            },
            None => {
                let rule_names: Vec<&str> = offered.rules.iter().map(|rule| rule.name.as_str()).collect();
                scope.unknown(&code::JOB_REFERENCE, "margin rule", &name.value, &name.place, &rule_names);
            }
        }
    }
    rules
}
