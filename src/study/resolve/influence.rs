//! Which inputs can move what sensors read: a model may hold parts that a test does not touch.

use crate::expression::{ExprId, Graph, Symbol};
use crate::measurement::Sensor;
use crate::study::resolved::Pass;
use crate::thermal::{Clock, Model, NodeKind};

/// Names of the inputs on which no sensor reading of a pass depends in its model; none where not all readings are there, or the model
/// is another program's.
pub fn unused(pass: &Pass) -> Vec<&str> {
    let model = &pass.model;
    let sensors: Vec<&Sensor> = pass.measurements.iter().flat_map(|measurement| &measurement.sensors).collect();
    if sensors.is_empty() || !pass.missing.is_empty() || model.external.is_some() {
        return Vec::new();
    }
    let moves = inputs(model, &sensors);
    let is_clock = |input: usize| Clock::ALL.into_iter().any(|clock| model.clocks.get(clock) == Some(input));
    let is_unused = |input: &usize| !moves[*input] && !model.switches.contains(input) && !is_clock(*input);
    (0..model.inputs.len()).filter(is_unused).map(|input| model.inputs[input].name.as_str()).collect()
}

/// Of each input of the model whether it can move a reading of these sensors: it stands in their quantities, or in the
/// balance of a node that these depend on through others. Temperatures of boundaries are given and pass nothing on.
pub(super) fn inputs(model: &Model, sensors: &[&Sensor]) -> Vec<bool> {
    let mut graph = model.graph.clone();
    let mut balances: Vec<Vec<ExprId>> = vec![Vec::new(); model.nodes.len()];
    for element in &model.elements {
        for (node, heat) in element.contribution(&mut graph, &mut Vec::new(), false).heat {
            balances[node].push(heat);
        }
    }
    for (balance, node) in balances.iter_mut().zip(&model.nodes) {
        match node.kind {
            NodeKind::Boundary { temperature } => *balance = vec![temperature],
            NodeKind::Diffusion { capacity } => balance.push(capacity),
            NodeKind::Arithmetic => {}
        }
    }
    let mut moves = vec![false; model.inputs.len()];
    let mut reached = vec![false; model.nodes.len()];
    let mut open: Vec<usize> = Vec::new();
    let mut take = |graph: &Graph, root: ExprId, open: &mut Vec<usize>| {
        for symbol in graph.symbols(root) {
            match symbol {
                Symbol::Input(input) => moves[input as usize] = true,
                Symbol::Node(node) if !std::mem::replace(&mut reached[node as usize], true) => open.push(node as usize),
                _ => {}
            }
        }
    };
    for sensor in sensors {
        take(&graph, model.quantities[sensor.quantity].value.expression(), &mut open);
    }
    while let Some(node) = open.pop() {
        for &root in &balances[node] {
            take(&graph, root, &mut open);
        }
    }
    moves
}
