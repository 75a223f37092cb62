//! Which nodes hang together: a steady network needs from every node a path to something that fixes its temperature.

use super::model::{Model, NodeKind};

/// Names of the nodes of the first group that has no path (conductors, radiations, flows, coolers) to a boundary and
/// no heat of its own that depends on a temperature; `None` when every node has one.
pub(super) fn isolated_nodes(model: &Model) -> Option<Vec<String>> {
    isolated_nodes_beside(model, &[])
}

/// The same where some nodes are held at their temperatures, by node; those beyond the end of the list are not.
pub fn isolated_nodes_beside(model: &Model, held: &[bool]) -> Option<Vec<String>> {
    let mut group: Vec<usize> = (0..model.nodes.len()).collect();
    let is_held = |node: usize| held.get(node).copied().unwrap_or(false);
    let mut anchored: Vec<bool> = (model.nodes.iter().enumerate())
        .map(|(index, node)| is_held(index) || matches!(node.kind, NodeKind::Boundary { .. }))
        .collect();
    for element in &model.elements {
        let physics = element.physics();
        join(&mut group, &mut anchored, physics.joined());
        if let Some(node) = physics.anchored(&model.graph) {
            anchor(&mut group, &mut anchored, node);
        }
    }
    let lost = (0..model.nodes.len()).find(|&node| {
        let root = root(&mut group, node);
        !anchored[root]
    })?;
    let lost = root(&mut group, lost);
    let members = (0..model.nodes.len()).filter(|&node| root(&mut group, node) == lost);
    Some(members.map(|node| model.nodes[node].name.clone()).collect())
}

fn root(group: &mut [usize], mut node: usize) -> usize {
    while group[node] != node {
        group[node] = group[group[node]];
        node = group[node];
    }
    node
}

fn join(group: &mut [usize], anchored: &mut [bool], nodes: &[usize]) {
    for pair in nodes.windows(2) {
        let (a, b) = (root(group, pair[0]), root(group, pair[1]));
        let (low, high) = (a.min(b), a.max(b));
        group[high] = low;
        anchored[low] = anchored[low] || anchored[high];
    }
}

fn anchor(group: &mut [usize], anchored: &mut [bool], node: usize) {
    let root = root(group, node);
    anchored[root] = true;
}
