//! Where two JSON values differ: for `bmv diff` and the nightly check.

use std::fmt;

use serde::Serialize;
use serde_json::Value;

/// A place at which two values differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Place, as in `quantities[0].mean`; empty for the whole.
    pub path: String,
    /// What the first value has there; nothing if the place is new.
    pub before: Option<Value>,
    /// What the second value has there; nothing if the place is gone.
    pub after: Option<Value>,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if self.path.is_empty() { "everything" } else { &self.path };
        match (&self.before, &self.after) {
            (Some(before), Some(after)) => {
                write!(formatter, "{place}: {} -> {}", brief(before), brief(after))?;
                if let (Some(before), Some(after)) = (before.as_f64(), after.as_f64())
                    && before != 0.0
                {
                    write!(formatter, " ({:+.3e} of it)", (after - before) / before.abs())?;
                }
                Ok(())
            }
            (None, Some(after)) => write!(formatter, "{place}: new, {}", brief(after)),
            (Some(before), None) => write!(formatter, "{place}: gone, was {}", brief(before)),
            (None, None) => formatter.write_str(place),
        }
    }
}

/// All places at which two values differ, from top to bottom. Numbers are equal if they are the same number, however
/// written (2 and 2.0).
pub fn differences(before: &Value, after: &Value) -> Vec<Difference> {
    let mut differences = Vec::new();
    compare("", Some(before), Some(after), &mut differences);
    differences
}

fn compare(path: &str, before: Option<&Value>, after: Option<&Value>, found: &mut Vec<Difference>) {
    match (before, after) {
        (Some(Value::Object(before)), Some(Value::Object(after))) => {
            let dot = if path.is_empty() { "" } else { "." };
            for (name, value) in before {
                compare(&format!("{path}{dot}{name}"), Some(value), after.get(name), found);
            }
            for (name, value) in after.iter().filter(|(name, _)| !before.contains_key(*name)) {
                compare(&format!("{path}{dot}{name}"), None, Some(value), found);
            }
        }
        (Some(Value::Array(before)), Some(Value::Array(after))) => {
            for index in 0..before.len().max(after.len()) {
                compare(&format!("{path}[{index}]"), before.get(index), after.get(index), found);
            }
        }
        (Some(Value::Number(a)), Some(Value::Number(b))) if a.is_f64() != b.is_f64() && a.as_f64() == b.as_f64() => {}
        (before, after) if before == after => {}
        (before, after) => {
            found.push(Difference { path: path.to_owned(), before: before.cloned(), after: after.cloned() });
        }
    }
}

/// A value in at most 60 characters.
fn brief(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 60 {
        return text;
    }
    text.chars().take(57).chain("...".chars()).collect()
}
