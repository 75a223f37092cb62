//! JSON Schema (draft 2020-12) of written types.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::written::SCHEMA_LINK;

/// Shared definitions of a schema.
#[derive(Clone, Debug, Default)]
pub struct Schemas {
    definitions: BTreeMap<String, Value>,
}

/// A field of an object's schema.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its key.
    pub key: &'static str,
    /// What it means.
    pub description: &'static str,
    /// The schema of its value.
    pub schema: Value,
    /// Whether it must be there.
    pub required: bool,
}

impl Schemas {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Defines a type once, recursion included, and returns the reference to it.
    pub fn define(&mut self, name: &str, make: impl FnOnce(&mut Self) -> Value) -> Value {
        if !self.definitions.contains_key(name) {
            self.definitions.insert(name.to_owned(), Value::Null);
            let schema = make(self);
            self.definitions.insert(name.to_owned(), schema);
        }
        json!({"$ref": format!("#/$defs/{name}")})
    }

    /// The whole schema of a file, which may link to its schema.
    pub fn document<T: super::written::Written>(title: &str) -> Value {
        Self::document_with::<T>(title, |_| {})
    }

    /// The same with definitions that the type refers to and does not know.
    pub fn document_with<T: super::written::Written>(title: &str, define: impl FnOnce(&mut Self)) -> Value {
        let mut schemas = Self::new();
        let root = T::schema(&mut schemas);
        define(&mut schemas);
        let name = root["$ref"].as_str().and_then(|reference| reference.strip_prefix("#/$defs/"));
        let definition = name.and_then(|name| schemas.definitions.get_mut(name));
        if let Some(properties) = definition.and_then(|schema| schema["properties"].as_object_mut()) {
            let link = json!({"type": "string", "description": "The JSON Schema of this file, for editors."});
            properties.insert(SCHEMA_LINK.to_owned(), link);
        }
        let mut document = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": title,
            "$defs": schemas.definitions,
        });
        if let (Value::Object(document), Value::Object(root)) = (&mut document, root) {
            document.extend(root);
        }
        document
    }
}

/// Doc comments as one paragraph.
fn text(description: &str) -> String {
    description.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Adds a description beside whatever the schema says.
fn described(mut schema: Value, description: &str) -> Value {
    if let Value::Object(map) = &mut schema {
        map.insert("description".to_owned(), text(description).into());
    }
    schema
}

/// The schema of an object with fields; others are refused.
pub fn object(description: &str, fields: Vec<Field>) -> Value {
    let required: Vec<&str> = fields.iter().filter(|f| f.required).map(|f| f.key).collect();
    let properties: serde_json::Map<String, Value> = fields
        .iter()
        .map(|f| {
            // What is optional may be null.
            let schema = if f.required { f.schema.clone() } else { json!({"anyOf": [f.schema, {"type": "null"}]}) };
            (f.key.to_owned(), described(schema, f.description))
        })
        .collect();
    described(
        json!({"type": "object", "properties": properties, "required": required, "additionalProperties": false}),
        description,
    )
}

/// The schema of a choice between kinds: an object with one key.
pub fn choice(description: &str, kinds: Vec<(&str, &str, Value)>) -> Value {
    let kinds: Vec<Value> = kinds
        .into_iter()
        .map(|(key, description, schema)| {
            json!({
                "type": "object",
                "properties": {key: described(schema, description)},
                "required": [key],
                "additionalProperties": false,
            })
        })
        .collect();
    described(json!({"oneOf": kinds}), description)
}

/// The schema of one of some words.
pub fn words(description: &str, words: &[(&str, &str)]) -> Value {
    let words: Vec<Value> =
        words.iter().map(|(word, description)| described(json!({"const": word}), description)).collect();
    described(json!({"oneOf": words}), description)
}
