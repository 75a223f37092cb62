//! A number that is known, or has a prior and is inferred, as written.

use serde_json::json;

use crate::document::{Amount, Diagnostics, Node, Schemas, Written, WrittenUnit, written_struct};

use crate::study::model::PriorForm;

/// A known value, or `{"prior": ..., "unit": ...}`.
#[derive(Clone, Debug, PartialEq)]
pub enum UncertainForm {
    /// A known value.
    Known(Amount),
    /// Inferred under a prior.
    Inferred(Box<InferredForm>),
}

written_struct! {
    /// A value that is inferred under a prior.
    pub struct InferredForm: "an object {\"prior\": ..., \"unit\": ...}" {
        /// The prior.
        required prior: PriorForm,
        /// Unit of the prior's numbers; SI where it is left out.
        optional unit: WrittenUnit,
        /// The value in the model as delivered; the prior's median where it is left out.
        optional nominal: Amount,
    }
}

impl Written for UncertainForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match node.get("prior") {
            Some(_) => Box::read(node, diagnostics).map(Self::Inferred),
            None => Amount::read(node, diagnostics).map(Self::Known),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [Amount::schema(schemas), InferredForm::schema(schemas)]})
    }
    fn expected() -> String {
        format!("{}, or {{\"prior\": ..., \"unit\": ...}}", Amount::expected())
    }
}
