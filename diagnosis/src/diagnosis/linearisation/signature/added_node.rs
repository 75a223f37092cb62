//! Effects that add one node with paths of constant conductance, such as a hidden node or a wall that stores: what their probes are
//! as nodes of a network linearised along its course.

use super::Base;
use super::probe::Probes;
use crate::effect::Effect;
use crate::expression::{ExprId, Symbol};
use crate::measurement::{Measurement, Rows};
use crate::thermal::transient::linearised::AddedNode;
use crate::thermal::{Model, NodeKind};

/// A candidate with the nodes that its probes add.
pub struct Added {
    /// Position of the candidate.
    pub candidate: usize,
    /// The values of the effect's parameters, SI, each with the node at these.
    pub probes: Vec<(Vec<f64>, AddedNode)>,
}

/// Ends and conductance.
type Path = ([usize; 2], ExprId);

/// What a candidate's probes add to the model; `None` where that is more than a node with such paths.
pub fn added(base: &Base<'_>, position: usize, effect: &Effect) -> Option<Added> {
    let original = &base.problem.model;
    let Probes { hypothesis, applied, values } = Probes::new(base, position, effect).ok()?;
    let model = &hypothesis.model;
    let [(node, _)] = applied.nodes[..] else { return None };
    let is_plain = applied.given_storage.is_empty() && applied.sensors.is_empty();
    let is_same_otherwise = model.nodes.len() == original.nodes.len() + 1
        && original.nodes.iter().zip(&model.nodes).all(|(before, after)| before.kind == after.kind)
        && model.elements.len() >= original.elements.len()
        // What a replaced path carries may be read.
        && original.quantities == model.quantities;
    let NodeKind::Diffusion { capacity } = model.nodes[node].kind else { return None };
    if !(is_plain && is_same_otherwise) {
        return None;
    }
    // Paths of the node, and paths that are there no more.
    let (mut paths, mut removed): (Vec<(usize, ExprId)>, Vec<Path>) = (Vec::new(), Vec::new());
    for (place, after) in model.elements.iter().enumerate() {
        let before = original.elements.get(place);
        if before.is_some_and(|before| before.kind == after.kind) {
            continue;
        }
        let (between, conductance) = after.physics().linear_path()?;
        let host = match between {
            [a, b] if b == node => a,
            [a, b] if a == node => b,
            _ => return None,
        };
        paths.push((host, conductance));
        if let Some(before) = before {
            removed.push(before.physics().linear_path()?);
        }
    }
    let hosts: Vec<usize> = paths.iter().map(|(host, _)| *host).collect();
    let joins = |(ends, _): &Path| ends.iter().all(|end| hosts.contains(end)) && hosts.len() == 2;
    if hosts.is_empty() || hosts.len() > 2 || hosts.first() == hosts.get(1) || !removed.iter().all(joins) {
        return None;
    }
    // At a step of a held input what stores no heat jumps, and rows show it before.
    let stores = |host: &usize| matches!(original.nodes[*host].kind, NodeKind::Diffusion { .. });
    if !hosts.iter().all(stores) && base.problem.measurements.iter().any(has_steps) {
        return None;
    }
    let parameters = base.likelihood.full_parameters(base.unknowns);
    let first = applied.first_parameter;
    let node_at = |values: &Vec<f64>| {
        let value = |expression: ExprId| {
            let value = model.graph.evaluate(expression, &|symbol| match symbol {
                Symbol::Parameter(index) => {
                    let own = (index as usize).checked_sub(first).and_then(|own| values.get(own));
                    own.or(parameters.get(index as usize)).copied().unwrap_or(f64::NAN)
                }
                _ => f64::NAN,
            });
            Some(value).filter(|value| value.is_finite() && is_constant(model, expression))
        };
        let mut joined = [None; 2];
        for (slot, &(host, path)) in joined.iter_mut().zip(&paths) {
            *slot = Some((host, value(path)?));
        }
        let between = removed.iter().map(|&(_, conductance)| value(conductance)).sum::<Option<f64>>()?;
        Some(AddedNode { capacity: value(capacity)?, hosts: joined, between: -between })
    };
    let probes: Option<Vec<(Vec<f64>, AddedNode)>> =
        values.iter().map(|values| Some((values.clone(), node_at(values)?))).collect();
    Some(Added { candidate: position, probes: probes? })
}

/// Whether inputs are held from row to row.
fn has_steps(measurement: &Measurement) -> bool {
    matches!(&measurement.rows, Rows::Transient { inputs, .. } if inputs.columns.iter().any(|column| column.hold))
}

/// Whether an expression depends on parameters alone.
fn is_constant(model: &Model, expression: ExprId) -> bool {
    model.graph.symbols(expression).iter().all(|symbol| matches!(symbol, Symbol::Parameter(_)))
}
