//! The published schema of models agrees with what is read.

use bmv::study::model;
use serde_json::{Value, json};

/// Whether a value meets a schema, for the keywords that our schemas use.
fn meets(schema: &Value, value: &Value, root: &Value) -> bool {
    let Value::Object(rules) = schema else { return true };
    rules.iter().all(|(rule, content)| match rule.as_str() {
        "$ref" => {
            let name = content.as_str().and_then(|r| r.strip_prefix("#/$defs/")).expect("a local reference");
            meets(root["$defs"].get(name).expect("defined"), value, root)
        }
        "type" => match content.as_str().expect("one type") {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "number" => value.is_number(),
            "integer" => value.as_f64().is_some_and(|f| f.fract() == 0.0),
            "boolean" => value.is_boolean(),
            "null" => value.is_null(),
            other => panic!("unknown type {other}"),
        },
        "anyOf" => content.as_array().expect("a list").iter().any(|s| meets(s, value, root)),
        "oneOf" => content.as_array().expect("a list").iter().filter(|s| meets(s, value, root)).count() == 1,
        "const" => content == value,
        "required" => {
            content.as_array().expect("a list").iter().all(|k| value.get(k.as_str().expect("a key")).is_some())
        }
        "properties" => value.as_object().is_none_or(|object| {
            object.iter().all(|(key, value)| content.get(key).is_none_or(|schema| meets(schema, value, root)))
        }),
        "additionalProperties" => value.as_object().is_none_or(|object| {
            let own = rules.get("properties").and_then(Value::as_object);
            object.iter().filter(|(key, _)| own.is_none_or(|own| !own.contains_key(*key))).all(|(_, value)| {
                match content {
                    Value::Bool(allowed) => *allowed,
                    schema => meets(schema, value, root),
                }
            })
        }),
        "items" => value.as_array().is_none_or(|items| items.iter().all(|item| meets(content, item, root))),
        "minItems" => value.as_array().is_none_or(|items| items.len() as u64 >= content.as_u64().expect("a count")),
        "maxItems" => value.as_array().is_none_or(|items| items.len() as u64 <= content.as_u64().expect("a count")),
        "minimum" => value.as_f64().is_none_or(|v| v >= content.as_f64().expect("a number")),
        "$schema" | "$defs" | "title" | "description" | "examples" => true,
        other => panic!("unknown keyword {other}"),
    })
}

#[test]
fn the_schema_accepts_what_is_read() {
    let schema = model::schema();
    let whole: Value = serde_json::from_str(include_str!("whole.json")).expect("JSON");
    assert!(meets(&schema, &whole, &schema));
}

#[test]
fn the_schema_refuses_what_is_refused() {
    let schema = model::schema();
    let with = |path: &str, value: Value| {
        let mut whole: Value = serde_json::from_str(include_str!("whole.json")).expect("JSON");
        *whole.pointer_mut(path).expect("there") = value;
        whole
    };
    for (path, value) in [
        ("/nodes/mid", json!({"capcity": 900})),
        ("/nodes/plate/capacity", json!([900])),
        ("/conductors/bolts", json!({"between": ["plate", "interface"]})),
        ("/conductors/bolts/between", json!(["plate"])),
        ("/parameters/G/prior", json!({"unifrom": [400, 1200]})),
        ("/parameters/G/prior", json!({"uniform": [400, 1200], "fixed": 3})),
        ("/inputs/T_if/settable", json!("yes")),
        ("/quantities/peak", json!({"over_time": {"median": "lid"}})),
    ] {
        assert!(!meets(&schema, &with(path, value.clone()), &schema), "{path}: {value}");
    }
}

#[test]
fn every_field_is_described() {
    let schema = model::schema();
    let mut fields = 0;
    for (name, definition) in schema["$defs"].as_object().expect("definitions") {
        for (key, field) in definition.get("properties").and_then(Value::as_object).into_iter().flatten() {
            assert!(field["description"].as_str().is_some_and(|d| d.len() > 3), "{name}.{key}");
            fields += 1;
        }
    }
    assert!(fields > 70, "{fields}");
}
