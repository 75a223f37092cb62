//! Thermoelectric cooler as response surfaces: the temperature of its cold side and its current as functions of voltage and hot
//! side, fitted to a test (J. Stout, PhD thesis, MIT, 2015, chapter 5, surface fits of detector temperature and current).
//!
//! The surfaces hold the load at the cold side as it was in the test. What the cold side draws from the hot side returns to it
//! through the cooler, so that the hot side is heated by the electrical power less that of the leads, `V i - i^2 R_lead`. The
//! coefficients are parameters like others: their posterior carries the error of the fit on.

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::{Binary, Dependence, Dimension, ExprId, Graph, Unary};

use super::form::{ElementForm, Lookup};
use super::{Contribution, Description, Drawing, ElementKind, Physics, SignConstraint, Source, Switch, sign};

/// A cooler given by surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCooler {
    /// The node on its hot side, which is heated.
    pub hot: usize,
    /// Voltage over cooler and leads, V.
    pub voltage: ExprId,
    /// Current, A, as a function of voltage and temperature of the hot side.
    pub current: ExprId,
    /// Temperature of the cold side, K, as a function of the same.
    pub cold_side: ExprId,
    /// Resistance of the leads, ohm, dissipated outside the network.
    pub lead_resistance: ExprId,
}

impl Physics for SurfaceCooler {
    fn kind(&self) -> &'static str {
        "surface cooler"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let total = graph.multiply(self.voltage, self.current);
        let two = graph.number(2.0);
        let square = graph.binary(Binary::Power, self.current, two);
        let leads = graph.multiply(self.lead_resistance, square);
        let heat = graph.subtract(total, leads);
        let balance_scale = graph.unary(Unary::Abs, heat);
        Contribution {
            heat: vec![(self.hot, heat)],
            balance_scale: vec![(self.hot, balance_scale)],
            through: Some(heat),
            current: Some(self.current),
            cold_side: Some(self.cold_side),
            ..Contribution::default()
        }
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({
            "hot": self.hot,
            "voltage": number(self.voltage),
            "current": number(self.current),
            "cold_side": number(self.cold_side),
            "lead_resistance": number(self.lead_resistance),
        })
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = format!("into {}", name(self.hot));
        let others = vec![self.current, self.cold_side, self.lead_resistance];
        Description { what: "cooler by response surfaces", ends, value: self.voltage, unit: "V", others }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Source(Source::Load)
    }

    fn heated(&self) -> Option<usize> {
        Some(self.hot)
    }

    fn anchored(&self, graph: &Graph) -> Option<usize> {
        graph.dependence(self.current).intersects(Dependence::NODE).then_some(self.hot)
    }

    fn sign_constraints(&self) -> Vec<SignConstraint> {
        vec![SignConstraint::at_least_zero(sign::LEADS, "ohm", self.lead_resistance)]
    }
}

const VOLTAGE: Expected = Expected::value(Dimension::VOLTAGE, "a voltage");
const CURRENT: Expected = Expected::value(Dimension::CURRENT, "a current");
const TEMPERATURE: Expected = Expected::value(Dimension::TEMPERATURE, "a temperature");
const RESISTANCE: Expected = Expected::value(Dimension::RESISTANCE, "a resistance").given();

written_struct! {
    /// A thermoelectric cooler as response surfaces over voltage and hot side, the load at its cold side included.
    pub struct SurfaceCoolerForm: "a cooler by response surfaces" {
        /// The node on its hot side, which gets its electrical power less that of the leads.
        required hot: Spanned<String>,
        /// Voltage over cooler and leads, V.
        required voltage: Scalar,
        /// Current, A; of the voltage's input and the hot side's `T`.
        required current: Scalar,
        /// Temperature of the cold side, K; of the voltage's input and the hot side's `T`.
        required cold_side: Scalar,
        /// Resistance of the leads, ohm, dissipated outside.
        optional lead_resistance: Scalar,
        /// Description, for the report.
        optional description: String,
        /// Where the surfaces come from.
        optional source: String,
    }
}

impl ElementForm for SurfaceCoolerForm {
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        if let Some(resistance) = &self.lead_resistance {
            model.note("surface cooler", &name.value, sign::LEADS, resistance.place());
        }
        let hot = model.find_node(&self.hot.value, &self.hot.place, diagnostics)?;
        let mut formulas = model.formulas();
        let locals = [("T", formulas.node(hot))];
        let voltage = formulas.scalar(&self.voltage, VOLTAGE, &locals, diagnostics);
        let current = formulas.scalar(&self.current, CURRENT, &locals, diagnostics);
        let cold_side = formulas.scalar(&self.cold_side, TEMPERATURE, &locals, diagnostics);
        let lead_resistance = match &self.lead_resistance {
            Some(scalar) => formulas.scalar(scalar, RESISTANCE, &[], diagnostics),
            None => Some(formulas.graph.number(0.0)),
        };
        Some(ElementKind::SurfaceCooler(SurfaceCooler {
            hot,
            voltage: voltage?,
            current: current?,
            cold_side: cold_side?,
            lead_resistance: lead_resistance?,
        }))
    }
}
