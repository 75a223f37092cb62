//! Canonical JSON: one text for one meaning, so that its hash identifies a definition.
//!
//! Keys are sorted by their UTF-8 bytes; integers are exact (RFC 8785 would round those above 2^53, and give two
//! seeds one hash); other numbers have the shortest text that reads back to the same bits; a float with an
//! integral value prints like the integer, `-0` like `0`. There is no white space.

use serde_json::{Number, Value};

use crate::math::sort::sort_by;

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
            sort_by(&mut entries, |a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
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
