//! Which names are allowed, and what is said of one that is not known.

use super::visible::is_hidden;
use super::{Diagnostic, Diagnostics, Map, Place, code, suggest};
use crate::expression::scope::RESERVED;

/// Longer names are refused, in characters.
const LONGEST: usize = 100;

/// Checks the name of a parameter, input: letters, digits and underscores, not reserved.
pub fn check_symbol(name: &str, place: &Place, diagnostics: &mut Diagnostics) -> bool {
    if RESERVED.contains(&name) {
        diagnostics.push(
            Diagnostic::error(&code::RESERVED_NAME, place, format!("the name `{name}` is reserved"))
                .expected("a name that no expression already knows")
                .help(format!("rename it, for instance `{name}_0`")),
        );
        return false;
    }
    let letters = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !letters || name.len() > LONGEST {
        let tame: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let mut diagnostic =
            Diagnostic::error(&code::INVALID_NAME, place, format!("{name:?} is no name of a parameter or input"))
                .expected("letters, digits and underscores, beginning with a letter");
        if tame.starts_with(|c: char| c.is_ascii_alphabetic()) && tame.len() <= LONGEST {
            diagnostic = diagnostic.help(format!("write `{tame}`"));
        }
        diagnostics.push(diagnostic);
        return false;
    }
    true
}

/// Whether a text is allowed as any other name.
pub fn is_label(name: &str) -> bool {
    label_fault(name).is_none()
}

/// What is wrong with a name that is no symbol.
fn label_fault(name: &str) -> Option<String> {
    if name.is_empty() {
        Some("it is empty".to_owned())
    } else if name.trim() != name {
        Some("it begins or ends with a blank".to_owned())
    } else if name.chars().count() > LONGEST {
        Some(format!("it has more than {LONGEST} characters"))
    } else {
        name.chars().find(|&c| is_hidden(c) || matches!(c, ':' | '/')).map(|c| format!("it holds {c:?}"))
    }
}

/// Checks any other name: text without control characters, `:` or `/`, not blank at its ends.
pub fn check_label(name: &str, place: &Place, diagnostics: &mut Diagnostics) -> bool {
    let Some(fault) = label_fault(name) else { return true };
    diagnostics.push(
        Diagnostic::error(&code::INVALID_NAME, place, format!("the name {name:?} is not allowed: {fault}"))
            .expected("text without control characters, `:` or `/`"),
    );
    false
}

/// Checks all names of a map.
pub fn check_labels<T>(map: &Map<T>, diagnostics: &mut Diagnostics) {
    for entry in map {
        check_label(&entry.name, &entry.name_place, diagnostics);
    }
}

/// Reports a name that is not among `names`; `what` is such as `node`.
pub fn unknown<'a>(
    what: &str,
    name: &str,
    place: &Place,
    names: impl Iterator<Item = &'a str> + Clone,
    diagnostics: &mut Diagnostics,
) {
    let near = diagnostics.nearest(name, names.clone());
    let mut diagnostic = Diagnostic::error(&code::UNKNOWN_REFERENCE, place, format!("unknown {what} `{name}`"));
    diagnostic = match near {
        Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
        None if names.clone().next().is_none() => diagnostic.help(format!("the model has no {what}s")),
        None => diagnostic.help(format!("the {what}s are {}", suggest::listed(names, 12))),
    };
    diagnostics.push(diagnostic.expected(format!("the name of a {what}")));
}
