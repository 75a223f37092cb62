//! Linear conductor: heat from `a` to `b` is `G (Ta - Tb)`, W, with `G` in W/K (ESATAN's GL). `G` may depend on
//! the temperatures.

use crate::expression::{ExprId, Graph, Symbol, Unary};

use super::Contribution;

/// A linear conductor between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// The two nodes.
    pub between: [usize; 2],
    /// Conductance, W/K.
    pub conductance: ExprId,
}

impl Conductor {
    /// Heat into both nodes.
    pub fn contribution(&self, graph: &mut Graph) -> Contribution {
        let [a, b] = self.between;
        let (ta, tb) = (temperature(graph, a), temperature(graph, b));
        let difference = graph.subtract(ta, tb);
        let heat = graph.multiply(self.conductance, difference);
        let size = graph.add(ta, tb);
        let terms = graph.multiply(self.conductance, size);
        let magnitude = graph.unary(Unary::Abs, terms);
        between(graph, [a, b], heat, magnitude)
    }
}

/// The symbol of a node's temperature, K.
pub(super) fn temperature(graph: &mut Graph, node: usize) -> ExprId {
    graph.symbol(Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)))
}

/// A heat flow from the first to the second node.
pub(super) fn between(graph: &mut Graph, [a, b]: [usize; 2], heat: ExprId, magnitude: ExprId) -> Contribution {
    let loss = graph.negate(heat);
    Contribution {
        heat: vec![(a, loss), (b, heat)],
        magnitude: vec![(a, magnitude), (b, magnitude)],
        through: Some(heat),
        ..Contribution::default()
    }
}
