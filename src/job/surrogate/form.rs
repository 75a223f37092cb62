//! Settings of `surrogate` as written: there are none, for they stand in the model.

use serde_json::json;

use crate::document::written::wrong_type;
use crate::document::{Diagnostic, Diagnostics, Node, Schemas, Value, Written, code};

/// Settings of `surrogate`: an empty object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurrogateForm;

impl Written for SurrogateForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Object(entries) if entries.is_empty() => Some(Self),
            Value::Object(_) => {
                let message = "a job `surrogate` has no settings of its own";
                let diagnostic = Diagnostic::error(&code::JOB_SETTING, &node.place, message);
                diagnostics.push(diagnostic.expected("{}, and the settings under `surrogate` of the model"));
                None
            }
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }

    fn schema(_: &mut Schemas) -> serde_json::Value {
        json!({"type": "object", "maxProperties": 0})
    }

    fn expected() -> String {
        "an empty object, {}".to_owned()
    }
}
