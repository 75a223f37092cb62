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
pub(super) fn number_fault(word: &str) -> Option<&'static str> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grammar_of_rfc_8259() {
        for valid in ["0", "-0", "10", "0.5", "-1.25e-3", "1E+9", "123456789012345678901234567890"] {
            assert_eq!(number_fault(valid), None, "{valid}");
            assert!(serde_json::from_str::<f64>(valid).is_ok(), "{valid}");
        }
        for invalid in ["01", "-01", ".5", "1.", "+1", "1e", "1e+", "0x10", "1_000", "1.5.2", "-", "2K"] {
            assert!(number_fault(invalid).is_some(), "{invalid}");
            assert!(serde_json::from_str::<f64>(invalid).is_err(), "{invalid}");
        }
    }

    #[test]
    fn integral_floats_are_integers_where_they_are_exact() {
        assert_eq!(Number::Float(2.0).as_u64(), Some(2));
        assert_eq!(Number::Float(2.5).as_u64(), None);
        assert_eq!(Number::Float(1e300).as_u64(), None);
        assert_eq!(Number::Signed(-1).as_u64(), None);
        assert_eq!(Number::Unsigned(u64::MAX).as_u64(), Some(u64::MAX));
    }
}
