//! Finding the element behind a number that is not finite.

use crate::expression::{ExprId, Symbol};

use super::equations::Equations;
use super::steady::SteadyError;

impl Equations {
    /// The first element with a heat or a slope that is not finite at the state in a file of registers, with the
    /// temperatures it depends on; `None` if all are finite.
    pub(super) fn name_not_finite(&self, file: &[f64], nodes: &[String]) -> Option<SteadyError> {
        let lookup = |symbol: Symbol| self.program.symbol(symbol).map_or(f64::NAN, |place| file[place.index()]);
        let mut graph = self.graph.clone();
        for element in &self.heats {
            for &heat in &element.heats {
                let own: Vec<usize> = graph
                    .symbols(heat)
                    .into_iter()
                    .filter_map(|symbol| match symbol {
                        Symbol::Node(node) => Some(node as usize),
                        _ => None,
                    })
                    .collect();
                let mut checked: Vec<ExprId> = vec![heat];
                for &node in &own {
                    checked.push(graph.derivative(heat, Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX))));
                }
                if checked.iter().any(|&id| !graph.evaluate(id, &lookup).is_finite()) {
                    let temperatures = own
                        .into_iter()
                        .map(|node| {
                            let symbol = Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX));
                            (nodes[node].clone(), lookup(symbol))
                        })
                        .collect();
                    return Some(SteadyError::NotFinite { element: element.name.clone(), temperatures });
                }
            }
        }
        None
    }
}
