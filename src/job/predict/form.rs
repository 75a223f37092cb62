//! Settings of `predict` as written.

use crate::document::prior::PosteriorForm;
use serde_json::json;

use crate::document::{Amount, Diagnostics, Map, NameOr, Node, Schemas, Spanned, Value, Written, written_struct};
use crate::job::propagate::SamplingForm;
use crate::study::pass::variable::SweepForm;

written_struct! {
    /// Settings of `predict`.
    pub struct PredictForm: "settings of `predict`" {
        /// The `calibrate` job whose posterior is carried: one of this pass by its name, or `{"pass": ..., "job": ...}`. The
        /// pass's only one where it is left out.
        optional from: NameOr<Spanned<PosteriorForm>>,
        /// Quantities, as in `propagate`.
        optional quantities: Vec<Spanned<String>>,
        /// Number of samples, 4096 where it is left out.
        optional samples: Spanned<u64>,
        /// How the sample space is covered, `sobol` where it is left out.
        optional sampling: SamplingForm,
        /// Environments; all of the pass, else `nominal` with the inputs' nominal values.
        optional environments: Vec<Spanned<String>>,
        /// Requirements; all of the pass where they are left out.
        optional requirements: Vec<Spanned<String>>,
        /// A design variable with its values.
        optional sweep: Spanned<Map<SweepForm>>,
        /// Pairs of quantities whose joint distribution is wanted.
        default(Vec::new()) joint: Vec<[Spanned<String>; 2]>,
        /// Largest share of failed samples that is tolerated, 0.01 where it is left out.
        optional failure_limit: Spanned<f64>,
        /// What is added to the model; effects are adopted by the pass.
        optional with: WithForm,
    }
}

written_struct! {
    /// What is added to the model in a prediction.
    pub struct WithForm: "what is added to the model" {
        /// The model's discrepancy. A `discrepancy` job of this pass by its name, or `{"pass": ..., "job": ...}`: its law is added
        /// to the quantities that its sensors measure. Or a standard deviation by quantity, as a validation experiment found it:
        /// a normal error of that size is added to each sample.
        optional discrepancy: AddedForm,
    }
}

/// What is added: the result of a job, or standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub enum AddedForm {
    /// A job of this pass.
    Own(Spanned<String>),
    /// A job of another pass.
    Other(Spanned<PosteriorForm>),
    /// Standard deviations by quantity.
    Sizes(Map<Amount>),
}

impl Written for AddedForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        let is_text = |key: &str| matches!(node.get(key).map(|own| &own.value), Some(Value::String(_)));
        match &node.value {
            Value::String(_) => Spanned::read(node, diagnostics).map(Self::Own),
            // A standard deviation is no text.
            _ if is_text("pass") || is_text("job") => Spanned::read(node, diagnostics).map(Self::Other),
            _ => Map::read(node, diagnostics).map(Self::Sizes),
        }
    }

    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [{"type": "string"}, PosteriorForm::schema(schemas), Map::<Amount>::schema(schemas)]})
    }

    fn expected() -> String {
        "a `discrepancy` job, or standard deviations by quantity".to_owned()
    }
}
