//! Canonical JSON: one text for one meaning, so that its hash identifies a definition.
//!
//! Keys are sorted by their UTF-8 bytes; integers are exact (RFC 8785 would round those above 2^53, and give two
//! seeds one hash); other numbers have the shortest text that reads back to the same bits; a float with an
//! integral value prints like the integer, `-0` like `0`. There is no white space.

use serde_json::{Number, Value};

/// A value without a canonical text.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the number {0} has no JSON text; a finite number is needed")]
pub struct NotFinite(pub f64);

/// Integral floats below this magnitude print as integers; larger ones keep an exponent, in the one form of
/// [`float`], so that no text of hundreds of digits arises.
const INTEGRAL: f64 = 1e21;

/// The canonical text of a value.
///
/// # Errors
/// A number that is not finite. (`serde_json` turns such numbers into `null` before they get here: see
/// [`float`] for hashing raw numbers.)
pub fn canonical(value: &Value) -> Result<String, NotFinite> {
    let mut out = String::new();
    write(value, &mut out)?;
    Ok(out)
}

fn write(value: &Value, out: &mut String) -> Result<(), NotFinite> {
    match value {
        Value::Null => out.push_str("null"),
        Value::Bool(b) => out.push_str(if *b { "true" } else { "false" }),
        Value::Number(n) => out.push_str(&number(n)?),
        Value::String(s) => out.push_str(&quoted(s)),
        Value::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                write(item, out)?;
            }
            out.push(']');
        }
        Value::Object(map) => {
            // Sorted here, whatever order the map keeps: a dependency may switch that.
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
            out.push('{');
            for (i, (key, item)) in entries.into_iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                out.push_str(&quoted(key));
                out.push(':');
                write(item, out)?;
            }
            out.push('}');
        }
    }
    Ok(())
}

fn number(n: &Number) -> Result<String, NotFinite> {
    if let Some(u) = n.as_u64() {
        Ok(u.to_string())
    } else if let Some(i) = n.as_i64() {
        Ok(i.to_string())
    } else {
        float(n.as_f64().unwrap_or(f64::NAN))
    }
}

/// The canonical text of a float.
///
/// # Errors
/// NaN and the infinities.
pub fn float(value: f64) -> Result<String, NotFinite> {
    if !value.is_finite() {
        return Err(NotFinite(value));
    }
    if value == 0.0 {
        return Ok("0".to_owned());
    }
    let magnitude = value.abs();
    if (1e-6..INTEGRAL).contains(&magnitude) {
        // Rust's `Display` is the shortest text that reads back, without an exponent.
        return Ok(format!("{value}"));
    }
    Ok(format!("{value:e}"))
}

/// A JSON string literal with the fewest escapes.
pub fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            '\u{8}' => out.push_str("\\b"),
            '\u{c}' => out.push_str("\\f"),
            c if c < ' ' => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn one_meaning_has_one_text() {
        let text = |v: Value| canonical(&v).expect("finite");
        assert_eq!(text(json!({"b": 1.0, "a": [true, null, -0.0, "x"]})), r#"{"a":[true,null,0,"x"],"b":1}"#);
        assert_eq!(text(json!(1)), text(json!(1.0)));
        // Bytes, not characters of UTF-16: U+FF61 before U+1D306.
        assert_eq!(text(json!({"\u{1d306}": 1, "\u{ff61}": 2})), "{\"\u{ff61}\":2,\"\u{1d306}\":1}");
        assert_eq!(text(json!("\u{1}\n\"\\é")), "\"\\u0001\\n\\\"\\\\é\"");
    }

    #[test]
    fn integers_are_exact_and_floats_shortest() {
        for exact in ["18446744073709551615", "9007199254740993", "-9223372036854775808"] {
            let value: Value = serde_json::from_str(exact).expect("valid");
            assert_eq!(canonical(&value).as_deref(), Ok(exact));
        }
        for (value, expected) in [
            (0.1 + 0.2, "0.30000000000000004"),
            (1e-7, "1e-7"),
            (1e300, "1e300"),
            (5e-324, "5e-324"),
            (1e20, "100000000000000000000"),
            (-2.5, "-2.5"),
        ] {
            assert_eq!(float(value).as_deref(), Ok(expected));
        }
        assert!(float(f64::NAN).is_err() && float(f64::INFINITY).is_err());
    }
}
