//! Any heat flow between two nodes, W from the first to the second, as an expression of their temperatures. A flow that
//! goes one way is taken from nowhere.

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::{Dimension, ExprId, Graph, Unary};

use super::conductor::between;
use super::form::{ElementForm, Lookup, path};
use super::{At, Contribution, Description, Drawing, ElementKind, Path, Physics, Switch, arrows};

/// A heat flow given by an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The two nodes.
    pub between: [usize; 2],
    /// Heat from the first to the second, W.
    pub heat: ExprId,
    /// Whether the second node alone gets the heat and the first gives none: what a fluid that streams from the first to
    /// the second brings along, the fluid's own balance being left out.
    pub one_way: bool,
}

impl Physics for Flow {
    fn kind(&self) -> &'static str {
        "flow"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let balance_scale = graph.unary(Unary::Abs, self.heat);
        if self.one_way {
            let second = self.between[1];
            return Contribution {
                heat: vec![(second, self.heat)],
                balance_scale: vec![(second, balance_scale)],
                through: Some(self.heat),
                ..Contribution::default()
            };
        }
        between(graph, self.between, self.heat, balance_scale)
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        let mut identity = json!({"between": self.between, "heat": number(self.heat)});
        if self.one_way {
            identity["one_way"] = Value::Bool(true);
        }
        identity
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = arrows(&self.between, name);
        Description {
            what: if self.one_way { "heat flow, one way" } else { "heat flow" },
            ends,
            value: self.heat,
            unit: "W",
            others: Vec::new(),
        }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Path(Path::Flow)
    }

    fn joined(&self) -> &[usize] {
        &self.between
    }

    fn between(&self) -> Option<[usize; 2]> {
        Some(self.between)
    }

    fn between_mut(&mut self) -> Option<&mut [usize; 2]> {
        Some(&mut self.between)
    }

    fn conductance(&self, at: &At<'_>) -> Option<f64> {
        Some((at(self.heat, Some(self.between[0])) - at(self.heat, None)).abs())
    }
}

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
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        let (between, heat) = path(model, &self.between, &self.heat, HEAT, diagnostics)?;
        Some(ElementKind::Flow(Flow { between, heat, one_way: self.one_way }))
    }
}
