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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_that_is_all_but_certain_is_a_bound() {
        let said = [0.99999, 0.175, 2e-5].map(percent);
        assert_eq!(said, ["over 99.9 %", "17.5 %", "below 0.1 %"]);
    }

    #[test]
    fn one_of_a_thing_is_no_plural() {
        let said = [counted(1_u64, "block"), counted(2_usize, "block"), counted(0_u64, "held-out reading")];
        assert_eq!(said, ["1 block", "2 blocks", "0 held-out readings"]);
        assert_eq!([counted(1_u64, "trajectory"), counted(3_u64, "trajectory")], ["1 trajectory", "3 trajectories"]);
        assert_eq!(counted(2_u64, "day"), "2 days");
        assert_eq!(counted(2_u64, "box"), "2 boxes");
    }

    #[test]
    fn a_p_value_is_never_0() {
        let said = [0.0, 2e-288, 9.9e-7, 1e-6, 6.54e-5, 0.0029, 0.012, 0.05, 0.96, 1.0].map(p_value);
        let wanted = ["< 1e-6", "< 1e-6", "< 1e-6", "1.0e-6", "6.5e-5", "0.0029", "0.012", "0.050", "0.96", "1.00"];
        assert_eq!(said, wanted);
        assert_eq!([0.0, 0.96, f64::NAN].map(p_stated), ["p < 1e-6", "p = 0.96", "p = unknown"]);
    }
}
