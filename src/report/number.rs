//! Numbers as engineers read them: as many digits as the uncertainty allows, a true minus sign, never `-0.0`, no
//! prefixes, absolute temperatures in degrees Celsius where the study writes them so.

use crate::document::time::{unit_of_rate, unit_of_time};
use crate::expression::Unit;
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::math::functions::ln;

/// What stands for a number that is not there.
pub const NONE: &str = "\u{2014}";

/// A number with so many decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let text = format!("{:.decimals$}", value.abs());
    let is_zero = text.bytes().all(|b| matches!(b, b'0' | b'.'));
    if value < 0.0 && !is_zero { format!("\u{2212}{text}") } else { text }
}

/// A number with so many significant digits; very large and very small ones with a power of ten.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.max(1);
    let scientific = format!("{:.*e}", digits - 1, value.abs());
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
        return fixed(value, decimals);
    }
    let sign = if value < 0.0 { "\u{2212}" } else { "" };
    format!("{sign}{mantissa}\u{00A0}\u{00D7}\u{00A0}10{}", superscript(&exponent.to_string()))
}

/// A number that someone wrote: up to six significant digits, without zeros that say nothing.
pub fn as_given(value: f64) -> String {
    let text = significant(value, 6);
    let (digits, power) = text.split_at(text.find('\u{00A0}').unwrap_or(text.len()));
    if !digits.contains('.') {
        return text;
    }
    format!("{}{power}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// A number with the decimals that its standard error allows: two digits of the error.
pub fn with_error(value: f64, error: f64) -> String {
    if !value.is_finite() || !error.is_finite() || error <= 0.0 {
        return significant(value, 4);
    }
    let decimals = 1.0 - (ln(error) / ln(10.0)).floor();
    if (-5.0..0.0).contains(&decimals) {
        // Two digits of the error stand before the point.
        let step = (0..-decimals as i32).fold(1.0, |step, _| 10.0 * step);
        let cut = |number: f64| fixed((number / step).round() * step, 0);
        return format!("{} \u{00B1} {}", cut(value), cut(error));
    }
    if !(0.0..=9.0).contains(&decimals) {
        return format!("{} \u{00B1} {}", significant(value, 4), significant(error, 2));
    }
    format!("{} \u{00B1} {}", fixed(value, decimals as usize), fixed(error, decimals as usize))
}

/// A number with so many decimals and its sign, also when positive.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if value > 0.0 && text.bytes().any(|b| matches!(b, b'1'..=b'9')) { format!("+{text}") } else { text }
}

/// A probability: three decimals, more where it is nearly 1 or 0.
pub fn probability(value: f64) -> String {
    let rest = value.min(1.0 - value);
    if rest > 0.0 && rest < 0.0005 { fixed(value, 5) } else { fixed(value, 3) }
}

/// A share as a percentage.
pub fn percent(share: f64, decimals: usize) -> String {
    format!("{}\u{00A0}%", fixed(100.0 * share, decimals))
}

/// How a number in SI is shown: in which unit, from which zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Size of the unit, SI.
    factor: f64,
    /// Zero of the unit, SI.
    zero: f64,
    /// Unit, typeset; empty for a pure number.
    pub unit: String,
}

impl Shown {
    /// An absolute temperature in degrees Celsius.
    pub fn celsius() -> Self {
        Self { factor: 1.0, zero: CELSIUS_ZERO_K, unit: "\u{00B0}C".to_owned() }
    }

    /// A number of an SI unit, as it is.
    pub fn si(unit: &str) -> Self {
        Self { factor: 1.0, zero: 0.0, unit: typeset(unit) }
    }

    /// A quantity of an SI unit: an absolute temperature in degrees Celsius, all else as it is.
    pub fn quantity(unit: &str, is_temperature: bool) -> Self {
        if is_temperature && unit == "K" { Self::celsius() } else { Self::si(unit) }
    }

    /// A number in the unit in which a study writes it. A unit that does not parse, which a loaded study cannot
    /// have, leaves the number in SI and says so.
    pub fn written(unit: &str) -> Self {
        match Unit::parse(unit) {
            Ok(parsed) => Self { factor: parsed.difference_to_si(1.0), zero: parsed.to_si(0.0), unit: typeset(unit) },
            Err(_) => Self { factor: 1.0, zero: 0.0, unit: "SI".to_owned() },
        }
    }

    /// A parameter of about this size in the unit in which a study writes it: in that unit, but a slow change by the hour, day or year.
    pub fn parameter(unit: &str, size: f64) -> Self {
        let written = Self::written(unit);
        match unit_of_rate(unit, size) {
            Some((length, unit)) => Self { factor: written.factor / length, zero: 0.0, unit: typeset(&unit) },
            None => written,
        }
    }

    /// The same by a size in SI.
    pub fn parameter_of(unit: &str, size_si: f64) -> Self {
        Self::parameter(unit, Self::written(unit).difference().value(size_si))
    }

    /// Times up to this one, s, in the unit that suits them.
    pub fn time(longest_s: f64) -> Self {
        let (length, unit) = unit_of_time(longest_s);
        Self { factor: length, zero: 0.0, unit: unit.to_owned() }
    }

    /// The same unit for a difference or a spread.
    pub fn difference(&self) -> Self {
        if self.zero == 0.0 { self.clone() } else { Self { factor: self.factor, zero: 0.0, unit: "K".to_owned() } }
    }

    /// The number in this unit.
    pub fn value(&self, si: f64) -> f64 {
        (si - self.zero) / self.factor
    }

    /// Whether it is an absolute temperature.
    pub fn is_celsius(&self) -> bool {
        self.zero != 0.0
    }

    /// The number alone: hundredths of a kelvin for temperatures, otherwise four significant digits.
    pub fn number(&self, si: f64) -> String {
        let value = self.value(si);
        if self.is_celsius() || self.unit == "K" { fixed(value, 2) } else { significant(value, 4) }
    }

    /// The number with its unit.
    pub fn text(&self, si: f64) -> String {
        with_unit(&self.number(si), &self.unit)
    }

    /// `name [unit]`, for the title of an axis or a column.
    pub fn title(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} [{}]", self.unit) }
    }
}

/// How a number of about this size, in a unit as written, is stated: what it is to be multiplied by, and the unit, typeset. A slow change
/// is stated by the hour, day or year.
pub fn stated(unit: &str, size: f64) -> (f64, String) {
    unit_of_rate(unit, size).map_or_else(|| (1.0, typeset(unit)), |(length, unit)| (length, typeset(&unit)))
}

/// A number and a unit that is typeset already, held together.
pub fn with_unit(number: &str, unit: &str) -> String {
    if unit.is_empty() || number == NONE { number.to_owned() } else { format!("{number}\u{00A0}{unit}") }
}

/// A unit as it is printed: `m2` with a raised 2, `degC` with its sign, `1` empty.
pub fn typeset(unit: &str) -> String {
    match unit {
        "1" | "" => return String::new(),
        "degC" => return "\u{00B0}C".to_owned(),
        "deg" => return "\u{00B0}".to_owned(),
        "ohm" => return "\u{03A9}".to_owned(),
        _ => {}
    }
    let mut out = String::new();
    let mut power = String::new();
    let mut chars = unit.chars().peekable();
    while let Some(c) = chars.next() {
        let after_letter = out.chars().last().is_some_and(char::is_alphabetic);
        if c == '^' || (after_letter && (c.is_ascii_digit() || c == '-')) {
            if c != '^' {
                power.push(c);
            }
            while let Some(d) = chars.next_if(|d| d.is_ascii_digit() || *d == '.' || (*d == '-' && power.is_empty())) {
                power.push(d);
            }
            // A decimal power has no raised point that fonts agree on.
            if power.contains('.') {
                out.push('^');
                out.push_str(&power);
            } else {
                out.push_str(&superscript(&power));
            }
            power.clear();
        } else if c == '*' {
            out.push('\u{00B7}');
        } else {
            out.push(c);
        }
    }
    out
}

fn superscript(digits: &str) -> String {
    const RAISED: [char; 10] = [
        '\u{2070}', '\u{00B9}', '\u{00B2}', '\u{00B3}', '\u{2074}', '\u{2075}', '\u{2076}', '\u{2077}', '\u{2078}',
        '\u{2079}',
    ];
    digits
        .chars()
        .filter_map(|c| match c {
            '-' => Some('\u{207B}'),
            c => c.to_digit(10).map(|d| RAISED[d as usize]),
        })
        .collect()
}
