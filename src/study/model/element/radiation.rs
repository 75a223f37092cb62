//! Radiative exchanges as written.

use super::ElementForm;
use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::Dimension;
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{ElementKind, Radiation, law};

const EXCHANGE_AREA: Expected = Expected::value(Dimension::AREA, "an exchange area");

written_struct! {
    /// Radiative exchange.
    pub struct RadiationForm: "a radiation" {
        /// The two nodes.
        required between: [Spanned<String>; 2],
        /// Area x emittance x exchange factor, m2; sigma not included.
        required exchange_area: Scalar,
        /// Description, for the report.
        optional description: String,
        /// Where the value comes from.
        optional source: String,
    }
}

impl ElementForm for RadiationForm {
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.places.note("radiation", &name.value, law::EXCHANGE_AREA, self.exchange_area.place());
        let (between, exchange_area) = model.path(&self.between, &self.exchange_area, EXCHANGE_AREA, diagnostics)?;
        Some(ElementKind::Radiation(Radiation { between, exchange_area }))
    }
}
