//! Radiative exchange: heat from `a` to `b` is `sigma GR (Ta^4 - Tb^4)`, W, with the exchange area `GR` in m2
//! (area x emittance x exchange factor, `sigma` not included: ESATAN's GR).

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::{Dimension, ExprId, Graph, Unary};

use super::conductor::{between, temperature};
use super::form::{ElementForm, Lookup, path};
use super::{
    At, Contribution, Description, Drawing, ElementKind, Path, Physics, STEFAN_BOLTZMANN, SignConstraint, Switch,
    arrows, sign,
};
use crate::thermal::size::AT_K;

/// Radiative exchange between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radiation {
    /// The two nodes.
    pub between: [usize; 2],
    /// Exchange area, m2.
    pub exchange_area: ExprId,
}

impl Physics for Radiation {
    fn kind(&self) -> &'static str {
        "radiation"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let [a, b] = self.between;
        let four = graph.number(4.0);
        let (ta, tb) = (temperature(graph, a), temperature(graph, b));
        let (fa, fb) = (
            graph.binary(crate::expression::Binary::Power, ta, four),
            graph.binary(crate::expression::Binary::Power, tb, four),
        );
        let sigma = graph.number(STEFAN_BOLTZMANN);
        let factor = graph.multiply(sigma, self.exchange_area);
        let difference = graph.subtract(fa, fb);
        let heat = graph.multiply(factor, difference);
        let size = graph.add(fa, fb);
        let terms = graph.multiply(factor, size);
        let balance_scale = graph.unary(Unary::Abs, terms);
        between(graph, [a, b], heat, balance_scale)
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({"between": self.between, "exchange_area": number(self.exchange_area)})
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = arrows(&self.between, name);
        Description { what: "radiation", ends, value: self.exchange_area, unit: "m2", others: Vec::new() }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Path(Path::Radiation)
    }

    fn joined(&self) -> &[usize] {
        &self.between
    }

    fn between(&self) -> Option<[usize; 2]> {
        Some(self.between)
    }

    fn is_passive(&self) -> bool {
        true
    }

    fn between_mut(&mut self) -> Option<&mut [usize; 2]> {
        Some(&mut self.between)
    }

    fn conductance(&self, at: &At<'_>) -> Option<f64> {
        Some(4.0 * STEFAN_BOLTZMANN * at(self.exchange_area, None) * AT_K * AT_K * AT_K)
    }

    fn sign_constraints(&self) -> Vec<SignConstraint> {
        vec![SignConstraint::at_least_zero(sign::EXCHANGE_AREA, "m2", self.exchange_area)]
    }

    fn scaled(&mut self) -> Option<&mut ExprId> {
        Some(&mut self.exchange_area)
    }
}

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
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.note("radiation", &name.value, sign::EXCHANGE_AREA, self.exchange_area.place());
        let (between, exchange_area) = path(model, &self.between, &self.exchange_area, EXCHANGE_AREA, diagnostics)?;
        Some(ElementKind::Radiation(Radiation { between, exchange_area }))
    }
}
