//! How types are read from JSON: the trait, and plain values, arrays and files. Objects are declared with the
//! macros of [`super::declare`].

use serde_json::json;

use super::code;
use super::diagnostic::{Diagnostic, Diagnostics};
use super::json::{Node, Number, Value};
use super::schema::Schemas;
use super::source::{Place, Span};

/// A type that is read from a JSON value.
pub trait Written: Sized {
    /// Reads it. Errors go to `diagnostics`, and `None` comes back where there is no value because of them;
    /// a value may come back although errors were found beside it, so callers look at the diagnostics at the end.
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self>;

    /// The JSON Schema (draft 2020-12), with shared definitions put into `schemas`.
    fn schema(schemas: &mut Schemas) -> serde_json::Value;

    /// What is expected, for messages: `a number`, `a pair of numbers`.
    fn expected() -> String;
}

/// Reports a value of the wrong type (silent for what was no JSON, which has been reported). Always `None`.
pub fn wrong_type<T>(node: &Node, expected: &str, diagnostics: &mut Diagnostics) -> Option<T> {
    if node.value != Value::Invalid {
        let kind = node.value.kind();
        diagnostics.push(
            Diagnostic::error(&code::WRONG_TYPE, &node.place, format!("{kind} cannot stand here")).expected(expected),
        );
    }
    None
}

/// Reports a value outside its range. Always `None`.
pub fn out_of_range<T>(place: &Place, message: &str, expected: &str, diagnostics: &mut Diagnostics) -> Option<T> {
    diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, place, message).expected(expected));
    None
}

impl Written for bool {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.value {
            Value::Bool(b) => Some(b),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "boolean"})
    }
    fn expected() -> String {
        "true or false".to_owned()
    }
}

impl Written for f64 {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.value {
            Value::Number(n) => Some(n.as_f64()),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "number"})
    }
    fn expected() -> String {
        "a number".to_owned()
    }
}

impl Written for u64 {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.value {
            Value::Number(n) => n.as_u64().or_else(|| {
                let message = format!("{} is no integer from 0 to {}", node.place.text(), u64::MAX);
                out_of_range(&node.place, &message, &Self::expected(), diagnostics)
            }),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "integer", "minimum": 0})
    }
    fn expected() -> String {
        "an integer from 0".to_owned()
    }
}

impl Written for usize {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        // Counts above 2^32 are refused on every machine alike.
        let value = u64::read(node, diagnostics)?;
        match u32::try_from(value) {
            Ok(small) => Some(small as usize),
            Err(_) => {
                let message = format!("{value} is too large; at most {} is allowed", u32::MAX);
                out_of_range(&node.place, &message, &Self::expected(), diagnostics)
            }
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        u64::schema(schemas)
    }
    fn expected() -> String {
        u64::expected()
    }
}

impl Written for String {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::String(s) => Some(s.clone()),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "string"})
    }
    fn expected() -> String {
        "a string".to_owned()
    }
}

/// `null` is none.
impl<T: Written> Written for Option<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.value {
            Value::Null => Some(None),
            _ => T::read(node, diagnostics).map(Some),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [T::schema(schemas), {"type": "null"}]})
    }
    fn expected() -> String {
        format!("{} or null", T::expected())
    }
}

impl<T: Written> Written for Box<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        T::read(node, diagnostics).map(Self::new)
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        T::schema(schemas)
    }
    fn expected() -> String {
        T::expected()
    }
}

/// Any JSON, to be read later.
impl Written for Node {
    fn read(node: &Node, _: &mut Diagnostics) -> Option<Self> {
        (node.value != Value::Invalid).then(|| node.clone())
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({})
    }
    fn expected() -> String {
        "a value".to_owned()
    }
}

/// Reads every member; `None` if one is wrong, after reading all.
fn members<T: Written>(items: &[Node], diagnostics: &mut Diagnostics) -> Option<Vec<T>> {
    let read: Vec<Option<T>> = items.iter().map(|item| T::read(item, diagnostics)).collect();
    read.into_iter().collect()
}

impl<T: Written> Written for Vec<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(items) => members(items, diagnostics),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"type": "array", "items": T::schema(schemas)})
    }
    fn expected() -> String {
        format!("an array, each member {}", T::expected())
    }
}

impl<T: Written, const N: usize> Written for [T; N] {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(items) if items.len() == N => members(items, diagnostics)?.try_into().ok(),
            Value::Array(items) => {
                let message = format!("expected {N} members, found {}", items.len());
                diagnostics
                    .push(Diagnostic::error(&code::WRONG_LENGTH, &node.place, message).expected(Self::expected()));
                None
            }
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"type": "array", "items": T::schema(schemas), "minItems": N, "maxItems": N})
    }
    fn expected() -> String {
        format!("an array of {N}, each {}", T::expected())
    }
}

/// A value that remembers its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it stands.
    pub place: Place,
}

impl<T: Written> Written for Spanned<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        Some(Self { value: T::read(node, diagnostics)?, place: node.place.clone() })
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        T::schema(schemas)
    }
    fn expected() -> String {
        T::expected()
    }
}

/// One value, or an array of them.
#[derive(Clone, Debug, PartialEq)]
pub struct OneOrMany<T>(pub Vec<T>);

impl<T: Written> Written for OneOrMany<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(items) => members(items, diagnostics).map(Self),
            _ => T::read(node, diagnostics).map(|one| Self(vec![one])),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        let one = T::schema(schemas);
        json!({"anyOf": [one, {"type": "array", "items": one}]})
    }
    fn expected() -> String {
        format!("{}, or an array of such", T::expected())
    }
}

/// A name alone, or something longer.
#[derive(Clone, Debug, PartialEq)]
pub enum NameOr<T> {
    /// A string.
    Name(Spanned<String>),
    /// Anything else.
    Other(T),
}

impl<T: Written> Written for NameOr<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::String(_) => Spanned::read(node, diagnostics).map(Self::Name),
            Value::Object(_) | Value::Array(_) => T::read(node, diagnostics).map(Self::Other),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [{"type": "string"}, T::schema(schemas)]})
    }
    fn expected() -> String {
        format!("a name, or {}", T::expected())
    }
}

/// A number as JSON has it, integers exact.
impl Written for Number {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.value {
            Value::Number(n) => Some(n),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "number"})
    }
    fn expected() -> String {
        "a number".to_owned()
    }
}

/// Checks `"format"` of a file, which says what it is. `false` after an error.
pub fn check_format(node: &Node, format: &str, diagnostics: &mut Diagnostics) -> bool {
    if !matches!(node.value, Value::Object(_)) {
        wrong_type::<()>(node, "an object", diagnostics);
        return false;
    }
    let Some(stated) = node.get("format") else {
        let place = Place { span: Span::new(node.place.span.start, node.place.span.start + 1), ..node.place.clone() };
        diagnostics.push(
            Diagnostic::error(&code::MISSING_FIELD, &place, "missing field `format`")
                .expected(format!("\"format\": \"{format}\"")),
        );
        return false;
    };
    let Value::String(text) = &stated.value else {
        wrong_type::<()>(stated, &format!("the string \"{format}\""), diagnostics);
        return false;
    };
    if text == format {
        return true;
    }
    let formats = ["bmv-network/1", "bmv-pass/1", "bmv-effect/1"];
    let message = if formats.contains(&text.as_str()) {
        format!("this is a file of format `{text}`")
    } else {
        format!("unknown format `{text}`")
    };
    diagnostics.push(Diagnostic::error(&code::FORMAT_VERSION, &stated.place, message).expected(format!("`{format}`")));
    false
}

/// The field with which a file tells an editor its JSON Schema.
pub const SCHEMA_LINK: &str = "$schema";

/// Parses a file of a study. A link to its schema is for editors: it is a string, and no part of what the file says.
pub fn read_document(name: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<Node> {
    let mut node = super::json::parse_bytes(name, bytes, diagnostics)?;
    if let Value::Object(entries) = &mut node.value
        && let Some(position) = entries.iter().position(|entry| entry.key == SCHEMA_LINK)
    {
        // The place of a link that is no string is reported; the rest is read.
        String::read(&entries.remove(position).node, diagnostics);
    }
    Some(node)
}

/// Reads a file's bytes: JSON, its format, then the type. Beside the value stands the tree that it came from.
pub fn read_file<T: Written>(
    name: &str,
    bytes: &[u8],
    format: &str,
    diagnostics: &mut Diagnostics,
) -> Option<(T, Node)> {
    let node = read_document(name, bytes, diagnostics)?;
    if !check_format(&node, format, diagnostics) {
        return None;
    }
    let value = T::read(&node, diagnostics)?;
    Some((value, node))
}
