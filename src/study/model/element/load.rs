//! Heat loads as written.

use super::ElementForm;
use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::Dimension;
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{ElementKind, Load};

const POWER: Expected = Expected::value(Dimension::POWER, "a power");

written_struct! {
    /// Heat into a node.
    pub struct LoadForm: "a load" {
        /// The node.
        required into: Spanned<String>,
        /// Power, W; may depend on the node's `T`.
        required power: Scalar,
        /// Description, for the report.
        optional description: String,
        /// Where the value comes from.
        optional source: String,
    }
}

impl ElementForm for LoadForm {
    fn resolve(
        &self,
        _name: &Spanned<String>,
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        let into = model.find_node(&self.into.value, &self.into.place, diagnostics)?;
        let locals = [("T", model.formulas().node(into))];
        let power = model.formulas().scalar(&self.power, POWER, &locals, diagnostics)?;
        Some(ElementKind::Load(Load { into, power }))
    }
}
