//! Numbers inside sentences: counts with their nouns, probabilities and p-values.

use std::fmt::Display;

/// p below which only this bound is stated: so far out in its tail no test is exact, and nobody decides otherwise.
const LEAST_P: f64 = 1e-6;
/// p from which decimals are read more easily than a power of ten.
const READABLE_P: f64 = 1e-3;

/// A count with its noun, given for one: `1 block`, `2 blocks`, `0 trajectories`.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, noun: &str) -> String {
    if count == N::from(1) {
        return format!("{count} {noun}");
    }
    match noun.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'i', 'o', 'u']) => format!("{count} {stem}ies"),
        None if noun.ends_with(['s', 'x']) || noun.ends_with("ch") => format!("{count} {noun}es"),
        _ => format!("{count} {noun}s"),
    }
}

/// A clause with a capital letter, as a sentence begins.
pub fn upper(clause: &str) -> String {
    let mut letters = clause.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A p-value to two digits, or the bound that it lies below: `0.96`, `0.012`, `6.5e-5`, `< 1e-6`.
pub fn p_value(p: f64) -> String {
    match p {
        p if p.is_nan() => "unknown".to_owned(),
        p if p < LEAST_P => format!("< {LEAST_P:e}"),
        p if p < READABLE_P => format!("{p:.1e}"),
        p if p < 0.01 => format!("{p:.4}"),
        p if p < 0.1 => format!("{p:.3}"),
        p => format!("{p:.2}"),
    }
}

/// A p-value with its letter: `p = 0.012`, `p < 1e-6`.
pub fn p_stated(p: f64) -> String {
    let value = p_value(p);
    if value.starts_with('<') { format!("p {value}") } else { format!("p = {value}") }
}

/// A probability in per cent, or the bound beyond which digits say nothing: `over 99.9 %`, `below 0.1 %`, `17.5 %`.
pub fn percent(probability: f64) -> String {
    match probability {
        p if p > 0.999 => "over 99.9 %".to_owned(),
        p if p < 0.001 => "below 0.1 %".to_owned(),
        p => format!("{:.1} %", 100.0 * p),
    }
}
