//! What jobs choose by name: uncertain parameters, measurements.

use std::ops::Range;

use crate::document::{Diagnostic, Spanned, code};
use crate::random::Distribution;
use crate::study::job::Entry;

use super::parts::belongs_to;
use super::scope::{Scope, unknown};
use super::settings::{Offered, measurement, push_new};

/// Positions of the parameters that are not fixed.
pub fn uncertain(priors: &[Distribution]) -> Vec<usize> {
    (0..priors.len()).filter(|&index| !priors[index].is_fixed()).collect()
}

/// Positions of the named parameters, each of which must have a prior that is not fixed.
pub fn parameters(scope: &mut Scope, names: &[Spanned<String>], priors: &[Distribution]) -> Vec<usize> {
    let mut chosen = Vec::new();
    for name in names {
        match scope.resolved.parameter(&name.value) {
            Some(index) if priors[index].is_fixed() => {
                let message = format!("the prior of `{}` is fixed", name.value);
                let diagnostic = Diagnostic::error(&code::JOB_REFERENCE, &name.place, message);
                scope.diagnostics.push(diagnostic.help("leave it out, or give it a prior with a spread"));
            }
            Some(index) => push_new(&mut chosen, index),
            None => {
                let parameter_names = scope.resolved.model.parameters.iter().map(|parameter| parameter.name.as_str());
                let asked = ("parameter", name.value.as_str());
                unknown(scope.diagnostics, &code::JOB_REFERENCE, asked, &name.place, parameter_names);
            }
        }
    }
    chosen
}

/// The named parameters; all that are not fixed where none are named.
pub fn parameters_or_all(
    scope: &mut Scope,
    names: Option<&Vec<Spanned<String>>>,
    priors: &[Distribution],
) -> Vec<usize> {
    match names {
        Some(names) => {
            let chosen = parameters(scope, names, priors);
            with_errors(scope, chosen, priors)
        }
        None => uncertain(priors),
    }
}

/// The chosen parameters with those that are errors of a surrogate: nobody may leave these out by not naming them.
pub fn with_errors(scope: &Scope, mut chosen: Vec<usize>, priors: &[Distribution]) -> Vec<usize> {
    for index in errors(scope).filter(|&index| !priors[index].is_fixed()) {
        push_new(&mut chosen, index);
    }
    chosen
}

/// Positions of the parameters that are errors of a surrogate.
pub fn errors(scope: &Scope) -> Range<usize> {
    scope.resolved.model.external.as_ref().map_or(0..0, |external| external.errors.clone())
}

/// Positions of the named measurements, all of the pass where none are named, and names of those whose data are missing.
pub fn data(
    scope: &mut Scope,
    entry: &Entry,
    written: Option<&Vec<Spanned<String>>>,
    purpose: &str,
    offered: &Offered,
) -> (Vec<usize>, Vec<String>) {
    let (mut data, mut missing) = (Vec::new(), Vec::new());
    let mut add = |name: &str, position: Option<usize>| match position {
        Some(position) => push_new(&mut data, position),
        None => missing.push(name.to_owned()),
    };
    match written {
        Some(names) => {
            for name in names {
                if measurement(scope, &name.value, &name.place, offered).is_some() {
                    let parts = offered.measurements.iter().filter(|(part, _)| belongs_to(part, &name.value));
                    parts.for_each(|(part, position)| add(part, *position));
                }
            }
        }
        None => offered.measurements.iter().for_each(|(name, position)| add(name, *position)),
    }
    if data.is_empty() && missing.is_empty() && !scope.diagnostics.has_errors() {
        let message = format!("`{}` has no measurement to {purpose}", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "at least one entry under `measurements`");
    }
    (data, missing)
}
