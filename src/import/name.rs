//! Names of a deck as the study format allows them, changed as little as that takes.

use std::collections::{HashMap, HashSet};

use crate::document::name::{check_symbol, is_label};
use crate::document::visible::is_hidden;
use crate::document::{Diagnostics, Place, Source, Span};

/// Room for a number behind a name that is shortened.
const LONGEST: usize = 90;

/// Names of one kind that were given so far.
#[derive(Debug, Default)]
pub(super) struct Names {
    given: HashSet<String>,
}

impl Names {
    /// A name of a node, element or group: without control characters, `:` and `/`, not blank at its ends, unique.
    pub(super) fn label(&mut self, name: &str) -> String {
        let tame = if is_label(name) {
            name.to_owned()
        } else {
            let replaced = |c: char| if is_hidden(c) || matches!(c, ':' | '/') { '_' } else { c };
            let tame: String = name.trim().chars().map(replaced).take(LONGEST).collect();
            // Shortening may leave a blank at the end; nothing but what is hidden may have been there.
            if tame.trim().is_empty() { "unnamed".to_owned() } else { tame.trim().to_owned() }
        };
        self.unique(tame, " ")
    }

    /// A name of a parameter, input or table: letters, digits and underscores, a letter first, not reserved, unique.
    pub(super) fn symbol(&mut self, name: &str) -> String {
        let mut tame: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(LONGEST).collect();
        if !tame.starts_with(|c: char| c.is_ascii_alphabetic()) {
            tame.insert(0, 'p');
        }
        if !is_symbol(&tame) {
            tame.push_str("_0");
        }
        self.unique(tame, "_")
    }

    fn unique(&mut self, name: String, separator: &str) -> String {
        let mut unique = name.clone();
        let mut count = 1;
        while !self.given.insert(unique.clone()) {
            count += 1;
            unique = format!("{name}{separator}{count}");
        }
        unique
    }
}

/// Whether a parameter or input may have this name.
fn is_symbol(name: &str) -> bool {
    let nowhere = Place::in_text(&Source::new("", ""), Span::default());
    check_symbol(name, &nowhere, &mut Diagnostics::new())
}

/// The identifiers of an expression, with the text before each; what follows the last one stands alone.
fn parts(expression: &str) -> (Vec<(&str, &str)>, &str) {
    let (mut parts, mut from) = (Vec::new(), 0);
    let mut rest = expression.char_indices().peekable();
    while let Some((start, c)) = rest.next() {
        // The `e` of 1e5 belongs to the number.
        let is_number = c.is_ascii_digit() || c == '.';
        if !is_number && !c.is_ascii_alphabetic() && c != '_' {
            continue;
        }
        let mut end = start + c.len_utf8();
        let mut last = c;
        while let Some(&(at, next)) = rest.peek() {
            let is_sign = is_number && matches!(last, 'e' | 'E') && matches!(next, '+' | '-');
            let belongs = next.is_ascii_alphanumeric() || next == '_' || (is_number && next == '.') || is_sign;
            if !belongs {
                break;
            }
            (end, last) = (at + next.len_utf8(), next);
            rest.next();
        }
        if !is_number {
            // Both ends lie at boundaries of characters.
            parts.push((expression.get(from..start).unwrap_or(""), expression.get(start..end).unwrap_or("")));
            from = end;
        }
    }
    (parts, expression.get(from..).unwrap_or(""))
}

/// The identifiers of an expression.
pub(super) fn identifiers(expression: &str) -> Vec<&str> {
    parts(expression).0.into_iter().map(|(_, identifier)| identifier).collect()
}

/// An expression in which identifiers have other names.
pub(super) fn renamed(expression: &str, names: &HashMap<String, String>) -> String {
    let (parts, rest) = parts(expression);
    let mut text = String::with_capacity(expression.len());
    for (before, identifier) in parts {
        text.push_str(before);
        text.push_str(names.get(identifier).map_or(identifier, String::as_str));
    }
    text.push_str(rest);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_allowed_stay_and_others_change_little() {
        let mut names = Names::default();
        let labels = ["SUB.12", "a/b", " a_b ", "GL(3,7)", "", "\u{7}", "x\ty"].map(|name| names.label(name));
        assert_eq!(labels, ["SUB.12", "a_b", "a_b 2", "GL(3,7)", "unnamed", "_", "x_y"]);
        assert!(labels.iter().all(|label| is_label(label)));
        assert!(is_label(&names.label(&"long ".repeat(40))));
        let mut names = Names::default();
        let symbols = ["G_bi", "T", "_x", "12", "eps-mli", "eps_mli"].map(|name| names.symbol(name));
        assert_eq!(symbols, ["G_bi", "T_0", "p_x", "p12", "eps_mli", "eps_mli_2"]);
        assert!(symbols.iter().all(|symbol| is_symbol(symbol)));
    }

    #[test]
    fn identifiers_are_renamed_and_numbers_are_not() {
        let names = HashMap::from([("e".to_owned(), "e_0".to_owned()), ("T".to_owned(), "T_0".to_owned())]);
        let text = "1e5*e + 2.5E-3 * (T_x - T) / .5e+2";
        assert_eq!(identifiers(text), ["e", "T_x", "T"]);
        assert_eq!(renamed(text, &names), "1e5*e_0 + 2.5E-3 * (T_x - T_0) / .5e+2");
        assert_eq!(renamed("\u{3a9} + \u{e9}e", &names), "\u{3a9} + \u{e9}e_0");
    }
}
