//! Given values that cannot be, and finding the element behind a number that is not finite.

use crate::expression::{ExprId, Symbol};
use crate::math::lanes::Lanes;

use super::element::SignConstraint;
use super::equations::Equations;
use super::steady::SteadyError;

impl Equations {
    /// Whether boundary temperatures, controllers' bands and values that have a sign, as they stand in the file, are possible ones.
    pub(super) fn check_given<V: Lanes>(&self, file: &[V], lane: usize, nodes: &[String]) -> Result<(), SteadyError> {
        for &(node, register) in &self.boundaries {
            let temperature_k = file[register.index()].lane(lane);
            // Written so that a NaN is refused.
            if !(temperature_k >= 0.0) {
                return Err(SteadyError::Boundary { node: nodes[node].clone(), temperature_k });
            }
        }
        for (element, register) in &self.bands {
            let band_k = file[register.index()].lane(lane);
            if !(band_k > 0.0) {
                return Err(SteadyError::Band { element: element.clone(), band_k });
            }
        }
        for (element, constraint, register) in &self.signs {
            let value = file[register.index()].lane(lane);
            if constraint.is_broken_by(value) {
                let SignConstraint { what, unit, above_zero, .. } = *constraint;
                return Err(SteadyError::Sign { element: element.clone(), what, unit, value, above_zero });
            }
        }
        Ok(())
    }

    /// The first element with a heat or a slope that is not finite at the state in a file of registers, with the
    /// temperatures it depends on; `None` if all are finite.
    pub(super) fn name_not_finite(&self, file: &[f64], nodes: &[String]) -> Option<SteadyError> {
        let lookup = |symbol: Symbol| self.program.symbol(symbol).map_or(f64::NAN, |place| file[place.index()]);
        let mut graph = self.graph.clone();
        for element in &self.heats {
            for &heat in &element.heats {
                let dependencies: Vec<usize> = graph
                    .symbols(heat)
                    .into_iter()
                    .filter_map(|symbol| match symbol {
                        Symbol::Node(node) => Some(node as usize),
                        _ => None,
                    })
                    .collect();
                let mut checked: Vec<ExprId> = vec![heat];
                for &node in &dependencies {
                    checked.push(graph.derivative(heat, Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX))));
                }
                if checked.iter().any(|&id| !graph.evaluate(id, &lookup).is_finite()) {
                    let temperatures = dependencies
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
