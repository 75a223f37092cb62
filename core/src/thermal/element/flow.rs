//! Any heat flow between two nodes, W from the first to the second, as an expression of their temperatures.

use crate::expression::{ExprId, Graph, Unary};

use super::Contribution;
use super::conductor::between;

/// A heat flow given by an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The two nodes.
    pub between: [usize; 2],
    /// Heat from the first to the second, W.
    pub heat: ExprId,
}

impl Flow {
    /// Heat into both nodes.
    pub fn contribution(&self, graph: &mut Graph) -> Contribution {
        let magnitude = graph.unary(Unary::Abs, self.heat);
        between(graph, self.between, self.heat, magnitude)
    }
}
