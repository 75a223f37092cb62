//! Design variables as written: values and ranges.

use serde_json::json;

use crate::document::written::wrong_type;
use crate::document::{Amount, Diagnostics, Node, Schemas, Spanned, Value, Written, written_struct};

/// Values of a design variable.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepForm {
    /// One by one.
    List(Vec<Amount>),
    /// Equally spaced.
    Steps(Box<StepsForm>),
}

written_struct! {
    /// Equally spaced values.
    pub struct StepsForm: "an object {\"from\": ..., \"to\": ..., \"steps\": ...}" {
        /// First value; above `to` where the largest value that passes is wanted.
        required from: Amount,
        /// Last value.
        required to: Amount,
        /// Number of values, both ends included.
        required steps: Spanned<usize>,
    }
}

impl Written for SweepForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(_) => Vec::read(node, diagnostics).map(Self::List),
            Value::Object(_) => Box::read(node, diagnostics).map(Self::Steps),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [Vec::<Amount>::schema(schemas), StepsForm::schema(schemas)]})
    }
    fn expected() -> String {
        "an array of values, or {\"from\": ..., \"to\": ..., \"steps\": ...}".to_owned()
    }
}

written_struct! {
    /// A range of a design variable.
    pub struct RangeForm: "an object {\"from\": ..., \"to\": ...}" {
        /// Where the search starts; above `to` where the largest value that passes is wanted.
        required from: Amount,
        /// The end towards which requirements are easier to meet.
        required to: Amount,
    }
}
