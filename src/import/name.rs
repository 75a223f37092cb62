//! Names of a deck as the study format allows them, changed as little as that takes.

use std::collections::{HashMap, HashSet};

use crate::document::name::{check_symbol, is_label};
use crate::document::visible::is_hidden;
use crate::document::{Diagnostics, Place, Source, Span};

/// Room for a number behind a name that is shortened.
const LONGEST: usize = 90;

/// Names of one kind that were given so far.
#[derive(Debug, Default)]
pub struct Names {
    given: HashSet<String>,
}

impl Names {
    /// A name of a node, element or group: without control characters, `:` and `/`, not blank at its ends, unique.
    pub fn label(&mut self, name: &str) -> String {
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
    pub fn symbol(&mut self, name: &str) -> String {
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
pub fn is_symbol(name: &str) -> bool {
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
pub fn identifiers(expression: &str) -> Vec<&str> {
    parts(expression).0.into_iter().map(|(_, identifier)| identifier).collect()
}

/// An expression in which identifiers have other names.
pub fn renamed(expression: &str, names: &HashMap<String, String>) -> String {
    let (parts, rest) = parts(expression);
    let mut text = String::with_capacity(expression.len());
    for (before, identifier) in parts {
        text.push_str(before);
        text.push_str(names.get(identifier).map_or(identifier, String::as_str));
    }
    text.push_str(rest);
    text
}
