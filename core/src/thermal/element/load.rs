//! Heat into one node, W; may depend on the node's temperature.

use crate::expression::{ExprId, Graph, Unary};

use super::Contribution;

/// A heat load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The node that is heated.
    pub into: usize,
    /// Power, W.
    pub power: ExprId,
}

impl Load {
    /// Heat into the node.
    pub fn contribution(&self, graph: &mut Graph) -> Contribution {
        let magnitude = graph.unary(Unary::Abs, self.power);
        Contribution {
            heat: vec![(self.into, self.power)],
            magnitude: vec![(self.into, magnitude)],
            through: Some(self.power),
            ..Contribution::default()
        }
    }
}
