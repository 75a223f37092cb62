//! Heat into one node, W; may depend on the node's temperature.

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostics, Scalar, Spanned, written_struct};
use crate::expression::{Dependence, Dimension, ExprId, Graph, Unary};

use super::form::{ElementForm, Lookup};
use super::{Contribution, Description, Drawing, ElementKind, Physics, Source, Switch};

/// A heat load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The node that is heated.
    pub into: usize,
    /// Power, W.
    pub power: ExprId,
}

impl Physics for Load {
    fn kind(&self) -> &'static str {
        "load"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let balance_scale = graph.unary(Unary::Abs, self.power);
        Contribution {
            heat: vec![(self.into, self.power)],
            balance_scale: vec![(self.into, balance_scale)],
            through: Some(self.power),
            ..Contribution::default()
        }
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({"into": self.into, "power": number(self.power)})
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = format!("into {}", name(self.into));
        Description { what: "heat load", ends, value: self.power, unit: "W", others: Vec::new() }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Source(Source::Load)
    }

    fn heated(&self) -> Option<usize> {
        Some(self.into)
    }

    fn anchored(&self, graph: &Graph) -> Option<usize> {
        graph.dependence(self.power).intersects(Dependence::NODE).then_some(self.into)
    }

    fn scaled(&mut self) -> Option<&mut ExprId> {
        Some(&mut self.power)
    }
}

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
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        let into = model.find_node(&self.into.value, &self.into.place, diagnostics)?;
        let locals = [("T", model.formulas().node(into))];
        let power = model.formulas().scalar(&self.power, POWER, &locals, diagnostics)?;
        Some(ElementKind::Load(Load { into, power }))
    }
}
