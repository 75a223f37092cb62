//! Any heat flow between two nodes, W from the first to the second, as an expression of their temperatures.

use serde_json::{Value, json};

use crate::expression::{ExprId, Graph, Unary};

use super::{At, Contribution, Description, Drawing, Path, Physics, Switch, arrows};
use super::conductor::between;

/// A heat flow given by an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The two nodes.
    pub between: [usize; 2],
    /// Heat from the first to the second, W.
    pub heat: ExprId,
}

impl Physics for Flow {
    fn kind(&self) -> &'static str {
        "flow"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let balance_scale = graph.unary(Unary::Abs, self.heat);
        between(graph, self.between, self.heat, balance_scale)
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({"between": self.between, "heat": number(self.heat)})
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let ends = arrows(&self.between, name);
        Description { what: "heat flow", ends, value: self.heat, unit: "W", others: Vec::new() }
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

