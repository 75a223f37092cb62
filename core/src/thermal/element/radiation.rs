//! Radiative exchange: heat from `a` to `b` is `sigma GR (Ta^4 - Tb^4)`, W, with the exchange area `GR` in m2
//! (area x emittance x exchange factor, `sigma` not included: ESATAN's GR).

use crate::expression::{ExprId, Graph, Unary};

use super::conductor::{between, temperature};
use super::{Contribution, STEFAN_BOLTZMANN};

/// Radiative exchange between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radiation {
    /// The two nodes.
    pub between: [usize; 2],
    /// Exchange area, m2.
    pub exchange_area: ExprId,
}

impl Radiation {
    /// Heat into both nodes.
    pub fn contribution(&self, graph: &mut Graph) -> Contribution {
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
        let magnitude = graph.unary(Unary::Abs, terms);
        between(graph, [a, b], heat, magnitude)
    }
}
