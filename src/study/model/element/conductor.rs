//! Linear conductors as written.

use super::ElementForm;
use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::Dimension;
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{Conductor, ElementKind, law};

const CONDUCTANCE: Expected = Expected::value(Dimension::CONDUCTANCE, "a conductance");

written_struct! {
    /// A linear conductor.
    pub struct ConductorForm: "a conductor" {
        /// The two nodes.
        required between: [Spanned<String>; 2],
        /// Conductance, W/K; may depend on `Ta`, `Tb`, `Tm`.
        required conductance: Scalar,
        /// Description, for the report.
        optional description: String,
        /// Where the value comes from.
        optional source: String,
    }
}

impl ElementForm for ConductorForm {
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.places.note("conductor", &name.value, law::CONDUCTANCE, self.conductance.place());
        let (between, conductance) = model.path(&self.between, &self.conductance, CONDUCTANCE, diagnostics)?;
        Some(ElementKind::Conductor(Conductor { between, conductance }))
    }
}
