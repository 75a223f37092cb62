//! How large the hardware of a model is: what its nodes store and exchange.

use super::element::Element;
use super::model::{Model, NodeKind};
use crate::expression::Symbol;

/// Temperature at which a model is measured, K.
pub(super) const AT_K: f64 = 293.0;

/// Medians over the nodes at nominal parameters and inputs and room temperature; 0 where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    /// Heat capacity of a diffusion node, J/K.
    pub capacity: f64,
    /// Conductances and linearised radiations that meet at a node, W/K.
    pub conductance: f64,
}

impl Size {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        let at = |warm: Option<usize>| {
            move |symbol: Symbol| match symbol {
                Symbol::Parameter(index) => {
                    model.parameters.get(index as usize).map_or(0.0, |parameter| parameter.nominal)
                }
                Symbol::Input(index) => model.inputs.get(index as usize).map_or(0.0, |input| input.nominal),
                Symbol::Node(index) if warm == Some(index as usize) => AT_K + 1.0,
                Symbol::Node(_) => AT_K,
                Symbol::Time | Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => 0.0,
            }
        };
        let capacities = model.nodes.iter().filter_map(|node| match node.kind {
            NodeKind::Diffusion { capacity } => Some(model.graph.evaluate(capacity, &at(None))),
            NodeKind::Arithmetic | NodeKind::Boundary { .. } => None,
        });
        let mut met = vec![0.0; model.nodes.len()];
        let at_nodes = |id, warm| model.graph.evaluate(id, &at(warm));
        let paths = model.elements.iter().map(Element::physics);
        for (between, conductance) in
            paths.filter_map(|physics| Some((physics.between()?, physics.conductance(&at_nodes)?)))
        {
            for node in between.into_iter().filter(|_| conductance.is_finite()) {
                met[node] += conductance;
            }
        }
        let inner = model.nodes.iter().zip(met).filter(|(node, _)| !matches!(node.kind, NodeKind::Boundary { .. }));
        Self { capacity: median(capacities), conductance: median(inner.map(|(_, met)| met)) }
    }
}

/// The upper median of those above 0.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite() && *value > 0.0).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
