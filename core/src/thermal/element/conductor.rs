//! Linear conductor: heat from `a` to `b` is `G (Ta - Tb)`, W, with `G` in W/K (ESATAN's GL). `G` may depend on
//! the temperatures.

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::{Dimension, ExprId, Graph, Symbol, Unary};

use super::form::{ElementForm, Lookup, path};
use super::{At, Contribution, Description, Drawing, ElementKind, Path, Physics, SignConstraint, Switch, arrows, sign};

/// A linear conductor between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// The two nodes.
    pub between: [usize; 2],
    /// Conductance, W/K.
    pub conductance: ExprId,
}

impl Physics for Conductor {
    fn kind(&self) -> &'static str {
        "conductor"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let [a, b] = self.between;
        let (ta, tb) = (temperature(graph, a), temperature(graph, b));
        let difference = graph.subtract(ta, tb);
        let heat = graph.multiply(self.conductance, difference);
        let size = graph.add(ta, tb);
        let terms = graph.multiply(self.conductance, size);
        let balance_scale = graph.unary(Unary::Abs, terms);
        between(graph, [a, b], heat, balance_scale)
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({"between": self.between, "conductance": number(self.conductance)})
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = arrows(&self.between, name);
        Description { what: "conduction", ends, value: self.conductance, unit: "W/K", others: Vec::new() }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Path(Path::Conductor)
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

    fn linear_path(&self) -> Option<([usize; 2], ExprId)> {
        Some((self.between, self.conductance))
    }

    fn conductance(&self, at: &At<'_>) -> Option<f64> {
        Some(at(self.conductance, None))
    }

    fn sign_constraints(&self) -> Vec<SignConstraint> {
        vec![SignConstraint::at_least_zero(sign::CONDUCTANCE, "W/K", self.conductance)]
    }

    fn scaled(&mut self) -> Option<&mut ExprId> {
        Some(&mut self.conductance)
    }
}

/// The symbol of a node's temperature, K.
pub(super) fn temperature(graph: &mut Graph, node: usize) -> ExprId {
    graph.symbol(Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)))
}

/// A heat flow from the first to the second node.
pub(super) fn between(graph: &mut Graph, [a, b]: [usize; 2], heat: ExprId, balance_scale: ExprId) -> Contribution {
    let loss = graph.negate(heat);
    Contribution {
        heat: vec![(a, loss), (b, heat)],
        balance_scale: vec![(a, balance_scale), (b, balance_scale)],
        through: Some(heat),
        ..Contribution::default()
    }
}

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
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.note("conductor", &name.value, sign::CONDUCTANCE, self.conductance.place());
        let (between, conductance) = path(model, &self.between, &self.conductance, CONDUCTANCE, diagnostics)?;
        Some(ElementKind::Conductor(Conductor { between, conductance }))
    }
}
