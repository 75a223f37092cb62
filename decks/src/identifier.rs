//! Names of decks as identifiers, and names made unique.

use std::collections::HashSet;

/// Identifiers that stand for the deck's own names.
#[derive(Default)]
pub(crate) struct Identifiers {
    used: HashSet<String>,
}

/// Names that the expressions of a deck use themselves.
const RESERVED: [&str; 19] = [
    "t",
    "T",
    "Ta",
    "Tb",
    "pi",
    "exp",
    "log",
    "sqrt",
    "sin",
    "cos",
    "tanh",
    "min",
    "max",
    "abs",
    "step",
    "smoothstep",
    "clamp",
    "interp",
    "e",
];

impl Identifiers {
    /// Identifiers that differ from the names that expressions use themselves.
    pub(crate) fn beside_expressions() -> Self {
        Self { used: RESERVED.iter().map(|&name| name.to_owned()).collect() }
    }

    /// An identifier from a name, with a number behind it where it is used already.
    pub(crate) fn make(&mut self, name: &str) -> String {
        let mut identifier: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if identifier.chars().next().is_none_or(|c| c.is_ascii_digit()) {
            identifier.insert(0, '_');
        }
        unique(&mut self.used, identifier, "_")
    }
}

/// A name, with a separator and a number behind it where it is used already.
pub(crate) fn unique(used: &mut HashSet<String>, name: String, separator: &str) -> String {
    let mut candidate = name.clone();
    let mut count = 1;
    while !used.insert(candidate.clone()) {
        count += 1;
        candidate = format!("{name}{separator}{count}");
    }
    candidate
}
