//! JSON Schema of a study's files.

use serde_json::{Value, json};
use thiserror::Error;

use crate::document::Schemas;

use super::inherit::NAMED;
use super::job::Kinds;
use super::model::ModelForm;
use super::pass::PassForm;

/// A kind of file without a schema.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no schema of `{kind}`; there are {}", KINDS.join(", "))]
pub struct UnknownSchema {
    /// As asked for.
    pub kind: String,
}

/// The kinds of file with a schema.
pub const KINDS: &[&str] = &["model", "pass", "document", "effect", "rule", "criteria"];

/// The JSON Schema of a kind of file; `jobs` are the kinds of job that a pass may ask for.
///
/// # Errors
/// A kind without a schema.
pub fn schema(kind: &str, jobs: &Kinds) -> Result<Value, UnknownSchema> {
    match kind {
        "model" => Ok(Schemas::document::<ModelForm>("bmv model (bmv-network/1)")),
        "pass" => Ok(removable(Schemas::document_with::<PassForm>("bmv pass (bmv-pass/1)", |all| jobs.define(all)))),
        "document" => Ok(Schemas::document::<super::document::DocumentForm>("bmv document (bmv-document/1)")),
        "effect" => Ok(crate::effect::catalogue::schema()),
        "rule" => Ok(Schemas::document::<super::rule::RuleForm>("bmv margin rule (bmv-rule/1)")),
        "criteria" => Ok(Schemas::document::<super::profile::ProfileForm>("bmv criteria profile (bmv-criteria/1)")),
        _ => Err(UnknownSchema { kind: kind.to_owned() }),
    }
}

/// In a pass, `null` in place of a named entry removes what a parent has.
fn removable(mut schema: Value) -> Value {
    for section in NAMED {
        let entries = schema.pointer_mut(&format!("/$defs/PassForm/properties/{section}/anyOf/0/additionalProperties"));
        if let Some(entries) = entries {
            let kept = entries.take();
            *entries = json!({"anyOf": [kept, {"type": "null"}]});
        }
    }
    schema
}
