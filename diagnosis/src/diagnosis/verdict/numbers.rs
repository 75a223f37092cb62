//! Numbers and lists as people read them.

use crate::diagnosis::output::Amount;
use crate::document::time::unit_of_rate;
use crate::expression::unit::CELSIUS_ZERO_K;

/// A value and its spread, to two digits of the spread.
pub fn with_error(value: f64, sd: f64) -> String {
    let decimals = 1.0 - (crate::math::functions::ln(sd) / core::f64::consts::LN_10).floor();
    if sd > 0.0 && (0.0..=8.0).contains(&decimals) {
        let decimals = decimals as usize;
        return format!("{value:.decimals$} ± {sd:.decimals$}");
    }
    let largest = value.abs().max(sd);
    let power = (crate::math::functions::ln(largest) / core::f64::consts::LN_10).floor();
    // Far more digits than anybody reads, or nothing to divide by.
    if !(sd > 1e-6 * largest && largest < f64::INFINITY) || power == 0.0 {
        return format!("{} ± {}", short(value, 3), short(sd, 2));
    }
    // One power of ten for both.
    let unit = crate::math::functions::pow(10.0, power);
    format!("({})e{power}", with_error(value / unit, sd / unit))
}

/// A number of a unit as it is stated: what it is to be multiplied by, and the unit with a blank before it. `size` is about as large.
pub(super) fn stated(unit: &str, size: f64) -> (f64, String) {
    match unit_of_rate(unit, size) {
        Some((length, unit)) => (length, format!(" {unit}")),
        None if unit == "1" => (1.0, String::new()),
        None => (1.0, format!(" {unit}")),
    }
}

/// The same of a fitted parameter.
pub(super) fn stated_amount(amount: &Amount) -> (f64, String) {
    stated(&amount.unit, amount.value.abs().max(amount.sd))
}

/// A number to some significant digits.
pub fn short(value: f64, digits: usize) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || !magnitude.is_finite() {
        // Not "-0".
        return format!("{}", value + 0.0);
    }
    let power = (crate::math::functions::ln(magnitude) / core::f64::consts::LN_10).floor();
    if !(-4.0..6.0).contains(&power) {
        return format!("{value:.*e}", digits - 1);
    }
    format!("{value:.*}", (digits as f64 - 1.0 - power).max(0.0) as usize)
}

/// The same without zeros at its end.
pub fn rounded(value: f64, digits: usize) -> String {
    let text = short(value, digits);
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}

/// `a, b and c`.
pub(crate) fn joined(names: &[String]) -> String {
    joined_by(names, "and")
}

/// `a, b or c`.
pub(super) fn or_joined(names: &[String]) -> String {
    joined_by(names, "or")
}

fn joined_by(names: &[String], word: &str) -> String {
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} {word} {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

/// A temperature difference, K: in hundredths, a smaller one to two digits.
pub(super) fn kelvins(value: f64) -> String {
    if value < 0.095 { short(value, 2) } else { format!("{value:.2}") }
}

/// Decimals at most of errors that differ by little.
const MOST_DECIMALS: usize = 6;

/// Two errors of which the second follows the first, K: with so many decimals that they differ, up to six.
pub fn kelvins_before_and_after(errors: [f64; 2]) -> [String; 2] {
    let short = errors.map(kelvins);
    if short[0] != short[1] || errors[0] == errors[1] {
        return short;
    }
    let longer = (3..=MOST_DECIMALS).map(|decimals| errors.map(|value| format!("{value:.decimals$}")));
    longer.into_iter().find(|pair| pair[0] != pair[1]).unwrap_or(short)
}

/// A temperature in degC.
pub(super) fn degrees(temperature_k: f64) -> String {
    format!("{:.1}", temperature_k - CELSIUS_ZERO_K)
}
