//! Numbers of JSON: integers exact, and what is wrong with a text that is none.

/// A number: integers exact, others as the nearest float.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// An integer from 0.
    Unsigned(u64),
    /// A negative integer.
    Signed(i64),
    /// Any other number, finite.
    Float(f64),
}

impl Number {
    /// The value as the nearest float.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Unsigned(u) => u as f64,
            Self::Signed(i) => i as f64,
            Self::Float(f) => f,
        }
    }

    /// The value as an integer from 0, if it is one (`2.0` is; above 2^53 only what was written as an integer is).
    pub fn as_u64(self) -> Option<u64> {
        const EXACT: f64 = 9_007_199_254_740_992.0;
        match self {
            Self::Unsigned(u) => Some(u),
            Self::Float(f) if f.fract() == 0.0 && (0.0..=EXACT).contains(&f) => Some(f as u64),
            _ => None,
        }
    }
}

/// What is wrong with a word that begins like a number; `None` for a number of JSON.
pub fn number_fault(word: &str) -> Option<&'static str> {
    if word.starts_with('+') {
        return Some("it begins with `+`");
    }
    let rest = word.strip_prefix('-').unwrap_or(word);
    let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let whole = digits(rest);
    if whole == 0 {
        return Some("a digit is missing before the point");
    }
    if whole > 1 && rest.starts_with('0') {
        return Some("it begins with a zero");
    }
    let mut rest = &rest[whole..];
    if let Some(fraction) = rest.strip_prefix('.') {
        let count = digits(fraction);
        if count == 0 {
            return Some("a digit is missing behind the point");
        }
        rest = &fraction[count..];
    }
    if let Some(exponent) = rest.strip_prefix(['e', 'E']) {
        let exponent = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        let count = digits(exponent);
        if count == 0 {
            return Some("the exponent has no digits");
        }
        rest = &exponent[count..];
    }
    if rest.is_empty() { None } else { Some("other characters follow it") }
}
