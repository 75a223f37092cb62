//! Units: products of SI units with prefixes and powers, and conversion to SI.
//!
//! Factors: BIPM, The International System of Units (9th edition, 2019), tables 2, 4, 7 and 8.

use crate::math::functions;

use super::dimension::Dimension;

/// A unit: `si = value * factor + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub text: String,
    /// What it measures.
    pub dimension: Dimension,
    /// SI units in one of this unit.
    pub factor: f64,
    /// The SI value of this unit's zero: 273.15 for degC, else 0.
    pub offset: f64,
}

/// Why a unit could not be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct UnitError {
    /// First byte of the fault in the text.
    pub start: usize,
    /// One after its last byte.
    pub end: usize,
    /// What is wrong.
    pub message: String,
    /// Whether a symbol is unknown (else the text does not parse).
    pub unknown: bool,
    /// What to write instead.
    pub help: Option<String>,
}

impl Unit {
    /// The SI unit of a dimension.
    pub fn si(dimension: Dimension) -> Self {
        Self { text: dimension.to_string(), dimension, factor: 1.0, offset: 0.0 }
    }

    /// Reads a unit such as `W/(m2 K)`, `mW/K^1.25`, `%` or `degC`.
    ///
    /// # Errors
    /// Unknown symbols, with the nearest known; text that does not parse; `degC` inside a product.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        if text.len() > LONGEST {
            return Err(fault(0, 0, format!("the unit has {} bytes; at most {LONGEST} are read", text.len())));
        }
        let trimmed = text.trim();
        if ["degC", "°C", "℃"].contains(&trimmed) {
            return Ok(Self {
                text: trimmed.to_owned(),
                dimension: Dimension::TEMPERATURE,
                factor: 1.0,
                offset: CELSIUS_ZERO_K,
            });
        }
        let mut parser = Parser { text, at: 0, depth: 0 };
        let (factor, dimension) = parser.product()?;
        if let Some(c) = parser.peek() {
            return Err(fault(parser.at, parser.at + c.len_utf8(), format!("unexpected `{c}` in a unit")));
        }
        if !factor.is_normal() {
            let size = if factor < 1.0 { "small" } else { "large" };
            return Err(fault(0, text.len(), format!("the unit is too {size} for a float")));
        }
        Ok(Self { text: trimmed.to_owned(), dimension, factor, offset: 0.0 })
    }

    /// An absolute value in SI: 20 degC is 293.15 K.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// A difference or standard deviation in SI: 20 degC are 20 K.
    pub fn difference_to_si(&self, value: f64) -> f64 {
        value * self.factor
    }

    /// An SI value in this unit.
    pub fn from_si(&self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }

    /// An SI difference in this unit.
    pub fn difference_from_si(&self, value: f64) -> f64 {
        value / self.factor
    }

    /// What to write instead where the coulomb stands in the unit, in a thermal model most likely for degrees Celsius:
    /// `degC` alone, `K` in a product. `None` without a coulomb.
    pub fn without_coulomb(&self) -> Option<String> {
        if self.has_offset() {
            // `°C` is what is meant.
            return None;
        }
        if self.text == "C" {
            return Some("degC".to_owned());
        }
        let mut instead = String::with_capacity(self.text.len());
        let mut rest = self.text.as_str();
        while let Some(start) = rest.find(char::is_alphabetic) {
            let length = rest[start..].find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len() - start);
            let (before, word) = (&rest[..start], &rest[start..start + length]);
            instead.push_str(before);
            instead.push_str(if word == "C" { "K" } else { word });
            rest = &rest[start + length..];
        }
        instead.push_str(rest);
        (instead != self.text).then_some(instead)
    }

    /// Units in which the same values may have been written by mistake, the likeliest first: K and degC, a share and per
    /// cent, else those that are a thousand or a million times smaller or larger by their first symbol's prefix.
    pub fn easily_mistaken(&self) -> Vec<Self> {
        const TIMES: [f64; 4] = [1e-3, 1e3, 1e-6, 1e6];
        let swapped = match self.text.as_str() {
            "K" => vec!["degC"],
            "1" => vec!["%"],
            "%" => vec!["1"],
            _ if self.has_offset() => vec!["K"],
            _ => vec![],
        };
        let mut units: Vec<Self> = swapped.into_iter().filter_map(|text| Self::parse(text).ok()).collect();
        if self.has_offset() {
            return units;
        }
        let bare = PREFIXES.iter().filter_map(|(prefix, _)| self.text.strip_prefix(prefix));
        let texts: Vec<String> = std::iter::once(self.text.as_str())
            .chain(bare)
            .flat_map(|text| {
                [""].into_iter().chain(PREFIXES.iter().map(|(prefix, _)| *prefix)).map(move |p| format!("{p}{text}"))
            })
            .collect();
        let parsed: Vec<Self> = texts.iter().filter_map(|text| Self::parse(text).ok()).collect();
        for times in TIMES {
            let is_meant = |other: &&Self| {
                other.dimension == self.dimension && (other.factor / (self.factor * times) - 1.0).abs() < 1e-9
            };
            units.extend(parsed.iter().find(is_meant).cloned());
        }
        units
    }

    /// Whether it is a plain angle. Angles have no dimension, so that the text alone tells one from a share or a count.
    pub fn is_angle(&self) -> bool {
        self.dimension.is_none() && (self.text == "deg" || self.text.ends_with("rad"))
    }

    /// Whether it is an absolute scale with a zero of its own (degC).
    pub fn has_offset(&self) -> bool {
        self.offset != 0.0
    }

    /// The unit of differences: `K` for `degC`, else itself.
    pub fn difference_text(&self) -> &str {
        if self.has_offset() { "K" } else { &self.text }
    }
}

/// 0 degC in K.
pub const CELSIUS_ZERO_K: f64 = 273.15;

/// Longer texts are no units.
const LONGEST: usize = 200;

/// Brackets nested deeper are refused.
const DEEPEST: usize = 16;

/// Prefixes, longest first where one begins another (`da` before `d`).
const PREFIXES: &[(&str, f64)] = &[
    ("da", 1e1),
    ("Q", 1e30),
    ("R", 1e27),
    ("Y", 1e24),
    ("Z", 1e21),
    ("E", 1e18),
    ("P", 1e15),
    ("T", 1e12),
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("h", 1e2),
    ("d", 1e-1),
    ("c", 1e-2),
    ("m", 1e-3),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
    ("f", 1e-15),
    ("a", 1e-18),
    ("z", 1e-21),
    ("y", 1e-24),
];

/// A symbol: SI units in one, powers of kg m s A K mol cd, whether prefixes go with it.
type Symbol = (&'static str, f64, [i8; 7], bool);

const SYMBOLS: &[Symbol] = &[
    ("m", 1.0, [0, 1, 0, 0, 0, 0, 0], true),
    ("g", 1e-3, [1, 0, 0, 0, 0, 0, 0], true),
    ("s", 1.0, [0, 0, 1, 0, 0, 0, 0], true),
    ("A", 1.0, [0, 0, 0, 1, 0, 0, 0], true),
    ("K", 1.0, [0, 0, 0, 0, 1, 0, 0], true),
    ("mol", 1.0, [0, 0, 0, 0, 0, 1, 0], true),
    ("cd", 1.0, [0, 0, 0, 0, 0, 0, 1], true),
    ("Hz", 1.0, [0, 0, -1, 0, 0, 0, 0], true),
    ("N", 1.0, [1, 1, -2, 0, 0, 0, 0], true),
    ("Pa", 1.0, [1, -1, -2, 0, 0, 0, 0], true),
    ("J", 1.0, [1, 2, -2, 0, 0, 0, 0], true),
    ("W", 1.0, [1, 2, -3, 0, 0, 0, 0], true),
    ("C", 1.0, [0, 0, 1, 1, 0, 0, 0], true),
    ("V", 1.0, [1, 2, -3, -1, 0, 0, 0], true),
    ("F", 1.0, [-1, -2, 4, 2, 0, 0, 0], true),
    ("ohm", 1.0, [1, 2, -3, -2, 0, 0, 0], true),
    ("Ω", 1.0, [1, 2, -3, -2, 0, 0, 0], true),
    ("Ω", 1.0, [1, 2, -3, -2, 0, 0, 0], true),
    ("S", 1.0, [-1, -2, 3, 2, 0, 0, 0], true),
    ("Wb", 1.0, [1, 2, -2, -1, 0, 0, 0], true),
    ("T", 1.0, [1, 0, -2, -1, 0, 0, 0], true),
    ("H", 1.0, [1, 2, -2, -2, 0, 0, 0], true),
    ("lm", 1.0, [0, 0, 0, 0, 0, 0, 1], true),
    ("lx", 1.0, [0, -2, 0, 0, 0, 0, 1], true),
    ("Bq", 1.0, [0, 0, -1, 0, 0, 0, 0], true),
    ("Gy", 1.0, [0, 2, -2, 0, 0, 0, 0], true),
    ("kat", 1.0, [0, 0, -1, 0, 0, 1, 0], true),
    ("rad", 1.0, [0; 7], true),
    ("sr", 1.0, [0; 7], true),
    ("bar", 1e5, [1, -1, -2, 0, 0, 0, 0], true),
    ("Torr", 101_325.0 / 760.0, [1, -1, -2, 0, 0, 0, 0], true),
    ("atm", 101_325.0, [1, -1, -2, 0, 0, 0, 0], false),
    ("L", 1e-3, [0, 3, 0, 0, 0, 0, 0], true),
    ("l", 1e-3, [0, 3, 0, 0, 0, 0, 0], true),
    ("eV", 1.602_176_634e-19, [1, 2, -2, 0, 0, 0, 0], true),
    ("Wh", 3600.0, [1, 2, -2, 0, 0, 0, 0], true),
    ("Ah", 3600.0, [0, 0, 1, 1, 0, 0, 0], true),
    ("min", 60.0, [0, 0, 1, 0, 0, 0, 0], false),
    ("h", 3600.0, [0, 0, 1, 0, 0, 0, 0], false),
    ("d", 86_400.0, [0, 0, 1, 0, 0, 0, 0], false),
    ("deg", std::f64::consts::PI / 180.0, [0; 7], false),
    ("%", 0.01, [0; 7], false),
    ("ppm", 1e-6, [0; 7], false),
    ("1", 1.0, [0; 7], false),
];

/// Words that people write, with what to write instead.
const HABITS: &[(&str, &str)] = &[
    ("celsius", "degC"),
    ("c", "degC"),
    ("deg_c", "degC"),
    ("degrees", "deg"),
    ("degree", "deg"),
    ("kelvin", "K"),
    ("degk", "K"),
    ("watt", "W"),
    ("watts", "W"),
    ("joule", "J"),
    ("joules", "J"),
    ("pascal", "Pa"),
    ("volt", "V"),
    ("volts", "V"),
    ("ampere", "A"),
    ("amp", "A"),
    ("amps", "A"),
    ("ohms", "ohm"),
    ("second", "s"),
    ("seconds", "s"),
    ("sec", "s"),
    ("minute", "min"),
    ("minutes", "min"),
    ("hour", "h"),
    ("hours", "h"),
    ("hr", "h"),
    ("day", "d"),
    ("days", "d"),
    ("meter", "m"),
    ("metre", "m"),
    ("kilogram", "kg"),
    ("gram", "g"),
    ("percent", "%"),
    ("none", "1"),
    ("-", "1"),
    ("pa", "Pa"),
    ("k", "K"),
    ("w", "W"),
    ("j", "J"),
    ("v", "V"),
    ("hz", "Hz"),
];

fn fault(start: usize, end: usize, message: String) -> UnitError {
    UnitError { start, end, message, unknown: false, help: None }
}

/// Factor and dimension of a symbol with its prefix.
fn symbol(text: &str) -> Option<(f64, Dimension)> {
    if let Some((_, factor, powers, _)) = SYMBOLS.iter().find(|s| s.0 == text) {
        return Some((*factor, Dimension::base(*powers)));
    }
    PREFIXES.iter().find_map(|(prefix, scale)| {
        let rest = text.strip_prefix(prefix)?;
        let (_, factor, powers, _) = SYMBOLS.iter().find(|s| s.3 && s.0 == rest)?;
        // A kilogram is exactly 1: the product 1e3 * 1e-3 is.
        Some((scale * factor, Dimension::base(*powers)))
    })
}

/// What to write instead of an unknown symbol.
fn instead(text: &str) -> Option<String> {
    let lower = text.to_lowercase();
    if let Some((_, right)) = HABITS.iter().find(|(word, _)| *word == lower) {
        return Some(format!("write `{right}`"));
    }
    let by_case = SYMBOLS.iter().map(|s| s.0).find(|s| s.to_lowercase() == lower);
    let common = ["mW", "kW", "mK", "mm", "cm", "km", "kg", "kJ", "mA", "mV", "mbar", "hPa", "kPa", "degC", "um", "ms"];
    let near = by_case.or_else(|| common.into_iter().find(|s| s.to_lowercase() == lower)).or_else(|| {
        let symbols = SYMBOLS.iter().map(|s| s.0).filter(|s| s.len() > 1).chain(common);
        symbols.filter(|s| one_edit(s, text)).min_by_key(|s| s.len().abs_diff(text.len()))
    })?;
    Some(format!("did you mean `{near}`?"))
}

/// Whether one insertion, deletion or replacement turns one text into the other.
fn one_edit(a: &str, b: &str) -> bool {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let head = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let tail = a[head..].iter().rev().zip(b[head..].iter().rev()).take_while(|(x, y)| x == y).count();
    a.len().max(b.len()) - head - tail <= 1 && a.len().max(b.len()) > 2
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    /// Skips blanks; tells whether there were any.
    fn blank(&mut self) -> bool {
        let before = self.at;
        while let Some(c) = self.peek().filter(|c| c.is_whitespace()) {
            self.at += c.len_utf8();
        }
        self.at > before
    }

    fn product(&mut self) -> Result<(f64, Dimension), UnitError> {
        self.blank();
        let (mut factor, mut dimension) = self.power()?;
        loop {
            let blank = self.blank();
            let divided = match self.peek() {
                Some('/') => {
                    self.at += 1;
                    true
                }
                Some(c @ ('*' | '.' | '·' | '⋅')) => {
                    self.at += c.len_utf8();
                    false
                }
                Some(c) if c != ')' && blank => false,
                _ => return Ok((factor, dimension)),
            };
            self.blank();
            let (f, d) = self.power()?;
            if divided {
                factor /= f;
                dimension = dimension.over(d);
            } else {
                factor *= f;
                dimension = dimension.times(d);
            }
        }
    }

    fn power(&mut self) -> Result<(f64, Dimension), UnitError> {
        let (factor, dimension) = self.atom()?;
        let start = self.at;
        let Some(exponent) = self.exponent()? else { return Ok((factor, dimension)) };
        if exponent.abs() > 12.0 {
            return Err(fault(start, self.at, format!("the power {exponent} of a unit is outside -12 to 12")));
        }
        let factor = if exponent == 1.0 { factor } else { functions::pow(factor, exponent) };
        Ok((factor, dimension.power(exponent)))
    }

    /// A power: `2`, `^2`, `^-1.25`, `-1`, `²`.
    fn exponent(&mut self) -> Result<Option<f64>, UnitError> {
        if let Some(power) = self.peek().and_then(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|s| s == c)) {
            self.at += self.peek().map_or(0, char::len_utf8);
            return Ok(Some(power as f64));
        }
        let marked = self.peek() == Some('^');
        if marked {
            self.at += 1;
        }
        let bracket = marked && self.peek() == Some('(');
        if bracket {
            self.at += 1;
        }
        let start = self.at;
        let rest = &self.text.as_bytes()[start..];
        let mut length = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
        let digits = |from: usize| rest[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let whole = digits(length);
        if whole == 0 {
            return if marked {
                Err(fault(start, start, "a power is missing behind `^`".to_owned()))
            } else {
                Ok(None)
            };
        }
        length += whole;
        if rest.get(length) == Some(&b'.') {
            let fraction = digits(length + 1);
            if fraction > 0 {
                length += 1 + fraction;
            }
        }
        self.at += length;
        let value = self.text[start..self.at].parse().unwrap_or(f64::NAN);
        if bracket {
            if self.peek() != Some(')') {
                return Err(fault(self.at, self.at, "the bracket round the power is not closed".to_owned()));
            }
            self.at += 1;
        }
        Ok(Some(value))
    }

    fn atom(&mut self) -> Result<(f64, Dimension), UnitError> {
        let start = self.at;
        match self.peek() {
            Some('(') => {
                if self.depth == DEEPEST {
                    return Err(fault(start, start + 1, format!("brackets nested deeper than {DEEPEST}")));
                }
                self.at += 1;
                self.depth += 1;
                let inner = self.product()?;
                self.depth -= 1;
                if self.peek() != Some(')') {
                    return Err(fault(start, start + 1, "the bracket is not closed".to_owned()));
                }
                self.at += 1;
                Ok(inner)
            }
            Some('1') => {
                self.at += 1;
                // Else `10 W` would be read as a power of 1: `1^0 W`.
                if let Some(c) = self.peek().filter(char::is_ascii_digit) {
                    let mut error = fault(start, self.at + c.len_utf8(), "a unit has no number but 1".to_owned());
                    error.help = Some("put the number into the value, or use a prefix such as `k` or `m`".to_owned());
                    return Err(error);
                }
                Ok((1.0, Dimension::NONE))
            }
            Some('%') => {
                self.at += 1;
                Ok((0.01, Dimension::NONE))
            }
            Some(c) if c.is_alphabetic() || matches!(c, '°' | '_') => {
                let rest = &self.text[start..];
                let length = rest.find(|c: char| !(c.is_alphabetic() || matches!(c, '°' | '_'))).unwrap_or(rest.len());
                self.at += length;
                let word = &rest[..length];
                if ["degC", "°C", "℃"].contains(&word) {
                    let mut error =
                        fault(start, self.at, "degC has an offset and cannot stand in a product".to_owned());
                    error.help = Some("write `K`: a difference of 1 degC is 1 K".to_owned());
                    return Err(error);
                }
                symbol(word).ok_or_else(|| UnitError {
                    start,
                    end: start + length,
                    message: format!("unknown unit `{word}`"),
                    unknown: true,
                    help: instead(word),
                })
            }
            Some(c) => Err(fault(start, start + c.len_utf8(), format!("expected a unit, found `{c}`"))),
            None => {
                let mut error = fault(start, start, "a unit is missing".to_owned());
                error.help = Some("write `1` for a number without unit".to_owned());
                Err(error)
            }
        }
    }
}
