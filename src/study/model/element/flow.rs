//! Heat flows as written.

use super::ElementForm;
use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::Dimension;
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{ElementKind, Flow};

const HEAT: Expected = Expected::value(Dimension::POWER, "a heat flow");

written_struct! {
    /// Any heat flow between two nodes.
    pub struct FlowForm: "a flow" {
        /// The two nodes.
        required between: [Spanned<String>; 2],
        /// Heat from the first to the second, W; of `Ta`, `Tb`, `Tm`.
        required heat: Scalar,
        /// Whether the second node alone gets the heat and the first gives none: what a stream brings along whose own
        /// balance the model leaves out.
        default(false) one_way: bool,
        /// Description, for the report.
        optional description: String,
        /// Where the value comes from.
        optional source: String,
    }
}

impl ElementForm for FlowForm {
    fn resolve(
        &self,
        _name: &Spanned<String>,
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        let (between, heat) = model.path(&self.between, &self.heat, HEAT, diagnostics)?;
        Some(ElementKind::Flow(Flow { between, heat, one_way: self.one_way }))
    }
}
