//! Groups that a model implies: members that share a parameter, as surfaces of one coating, nodes of one material or joints
//! of one kind do. What is wrong with one of them is often wrong with all.

use std::collections::BTreeMap;

use crate::expression::{ExprId, Symbol};
use crate::thermal::NodeKind;

use super::group::{Group, Members};
use super::resolve::ResolvedModel;

/// Most groups that are implied: each is a place for a dozen effects.
const MOST: usize = 12;

/// Groups beside those of the file, none with members of another: nodes whose joints with the same boundary share a
/// parameter, weighted by these joints' nominal values; nodes whose heat capacities share one, weighted by these;
/// conductors and radiations that share one; loads that share a parameter or an input. Weights add up to 1.
pub(super) fn implied(model: &ResolvedModel, written: &[Group]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (name, members) in surfaces(model).into_iter().chain(materials(model)).chain(alike(model)) {
        let is_known = |group: &Group| group.name == name || have_same_members(&group.members, &members);
        if groups.len() < MOST && !written.iter().chain(&groups).any(is_known) {
            groups.push(Group { name, members });
        }
    }
    groups
}

fn indices(members: &Members) -> Vec<usize> {
    let mut all: Vec<usize> = match members {
        Members::Nodes(nodes) => nodes.iter().map(|(node, _)| *node).collect(),
        Members::Conductors(elements) | Members::Radiations(elements) | Members::Loads(elements) => elements.clone(),
        Members::Sensors(_) => Vec::new(),
    };
    all.sort_unstable();
    all
}

fn have_same_members(one: &Members, other: &Members) -> bool {
    std::mem::discriminant(one) == std::mem::discriminant(other) && indices(one) == indices(other)
}

/// Nodes with weights that add up to 1; `None` of fewer than two, or where a weight is not above 0.
fn weighted(nodes: &BTreeMap<usize, f64>) -> Option<Members> {
    let total: f64 = nodes.values().sum();
    let is_sound = nodes.len() > 1 && total.is_finite() && nodes.values().all(|weight| *weight > 0.0);
    is_sound.then(|| Members::Nodes(nodes.iter().map(|(&node, weight)| (node, weight / total)).collect()))
}

/// Nodes whose joints of one kind with one boundary share a parameter.
fn surfaces(model: &ResolvedModel) -> Vec<(String, Members)> {
    let mut found: BTreeMap<(usize, &str, usize), BTreeMap<usize, f64>> = BTreeMap::new();
    let is_boundary = |node: usize| matches!(model.model.nodes[node].kind, NodeKind::Boundary { .. });
    for element in &model.model.elements {
        let Some([a, b]) = element.physics().between() else { continue };
        let (node, boundary) = if is_boundary(b) { (a, b) } else { (b, a) };
        if !is_boundary(boundary) || is_boundary(node) {
            continue;
        }
        let value = element.physics().description(&|node| node.to_string()).value;
        for parameter in parameters(model, value) {
            let key = (parameter, element.physics().kind(), boundary);
            *found.entry(key).or_default().entry(node).or_default() += nominal(model, value);
        }
    }
    let name = |(parameter, _, boundary): (usize, &str, usize)| {
        format!("nodes with {} to {}", model.model.parameters[parameter].name, model.model.nodes[boundary].name)
    };
    found.into_iter().filter_map(|(key, nodes)| Some((name(key), weighted(&nodes)?))).collect()
}

/// Nodes whose heat capacities share a parameter.
fn materials(model: &ResolvedModel) -> Vec<(String, Members)> {
    let mut found: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
    for (index, node) in model.model.nodes.iter().enumerate() {
        let NodeKind::Diffusion { capacity } = node.kind else { continue };
        for parameter in parameters(model, capacity) {
            found.entry(parameter).or_default().insert(index, nominal(model, capacity));
        }
    }
    let name = |parameter: usize| format!("nodes with {}", model.model.parameters[parameter].name);
    found.into_iter().filter_map(|(parameter, nodes)| Some((name(parameter), weighted(&nodes)?))).collect()
}

/// Conductors and radiations that share a parameter, and loads that share a parameter or an input.
fn alike(model: &ResolvedModel) -> Vec<(String, Members)> {
    let mut all = Vec::new();
    let conductors = ("conductor", Members::Conductors as fn(Vec<usize>) -> Members);
    for (kind, of) in [conductors, ("radiation", Members::Radiations), ("load", Members::Loads)] {
        let mut found: BTreeMap<Shared, Vec<usize>> = BTreeMap::new();
        for (index, element) in model.model.elements.iter().enumerate() {
            if element.physics().kind() == kind {
                let value = element.physics().description(&|node| node.to_string()).value;
                // Joints that follow one input need not be of one kind, but what it heats is heated by the same.
                let shared = shared(model, value).filter(|one| kind == "load" || matches!(one, Shared::Parameter(_)));
                shared.for_each(|one| found.entry(one).or_default().push(index));
            }
        }
        let name = |shared: Shared| match shared {
            Shared::Parameter(index) => format!("{kind}s with {}", model.model.parameters[index].name),
            Shared::Input(index) => format!("{kind}s with {}", model.model.inputs[index].name),
        };
        all.extend(found.into_iter().filter(|(_, own)| own.len() > 1).map(|(key, own)| (name(key), of(own))));
    }
    all
}

/// What members have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Shared {
    /// A parameter of the model.
    Parameter(usize),
    /// An input of the model.
    Input(usize),
}

/// The parameters and inputs in an expression.
fn shared(model: &ResolvedModel, value: ExprId) -> impl Iterator<Item = Shared> {
    let symbols = model.model.graph.symbols(value);
    symbols.into_iter().filter_map(|symbol| match symbol {
        Symbol::Parameter(index) => Some(Shared::Parameter(index as usize)),
        Symbol::Input(index) => Some(Shared::Input(index as usize)),
        _ => None,
    })
}

/// The parameters in an expression.
fn parameters(model: &ResolvedModel, value: ExprId) -> impl Iterator<Item = usize> {
    shared(model, value).filter_map(|one| match one {
        Shared::Parameter(index) => Some(index),
        Shared::Input(_) => None,
    })
}

/// The value of an expression with nominal parameters and inputs, at 293 K and at the start.
fn nominal(model: &ResolvedModel, value: ExprId) -> f64 {
    let of = |symbol: Symbol| match symbol {
        Symbol::Parameter(index) => model.model.parameters[index as usize].nominal,
        Symbol::Input(index) => model.model.inputs[index as usize].nominal,
        Symbol::Node(_) => 293.15,
        Symbol::Time | Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => 0.0,
    };
    model.model.graph.evaluate(value, &of)
}
