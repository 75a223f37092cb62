//! Numbers inside sentences: counts with their nouns, probabilities and p-values.

use std::fmt::Display;

/// p below which only this bound is stated: so far out in its tail no test is exact, and nobody decides otherwise.
const LEAST_P: f64 = 1e-6;
/// p from which decimals are read more easily than a power of ten.
const READABLE_P: f64 = 1e-3;

/// Digits from which a count has a comma at each thousand.
const GROUPED: usize = 5;

/// A count with a comma at each thousand, from 10,000 on: `9999`, `12,941,328`.
pub fn grouped(count: impl Display) -> String {
    let digits = count.to_string();
    if digits.len() < GROUPED || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return digits;
    }
    let is_before_thousand = |position: usize| position > 0 && (digits.len() - position).is_multiple_of(3);
    let with_comma =
        |(position, digit): (usize, char)| is_before_thousand(position).then_some(',').into_iter().chain([digit]);
    digits.chars().enumerate().flat_map(with_comma).collect()
}

/// A count with its noun, given for one: `1 block`, `2 blocks`, `0 trajectories`, `12,941,328 pairs`.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, noun: &str) -> String {
    if count == N::from(1) {
        return format!("{count} {noun}");
    }
    let count = grouped(count);
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
