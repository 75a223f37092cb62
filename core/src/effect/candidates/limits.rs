//! What of a model is a place.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::thermal::{Model, NodeKind};

/// Sizes of models up to which effects are tried at all places. In a larger model the diagnosis chooses places that its sensors
/// can tell apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Nodes of a model between any two of which effects are tried.
    pub nodes_in_pairs: usize,
    /// Nodes of a model at each of which, and at each of whose elements, effects are tried.
    pub nodes_one_by_one: usize,
    /// Elements of one kind that are places one by one in a model of any size.
    pub elements_of_a_kind: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { nodes_in_pairs: 64, nodes_one_by_one: 160, elements_of_a_kind: 64 }
    }
}

impl Limits {
    /// Whether pairs of nodes are to be chosen, since they are too many.
    pub fn choose_pairs(&self, model: &Model) -> bool {
        model.nodes.len() > self.nodes_in_pairs
    }

    /// Whether nodes and elements are to be chosen too.
    pub fn choose_members(&self, model: &Model) -> bool {
        model.nodes.len() > self.nodes_one_by_one
    }

    /// The elements among which places are to be chosen, ascending: those of kinds of which a large model has many.
    pub fn elements_to_choose(&self, model: &Model) -> Vec<usize> {
        if !self.choose_members(model) {
            return Vec::new();
        }
        let mut by_kind: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, element) in model.elements.iter().enumerate() {
            by_kind.entry(element.physics().kind()).or_default().push(index);
        }
        let many = by_kind.into_values().filter(|own| own.len() > self.elements_of_a_kind);
        let mut chosen: Vec<usize> = many.flatten().collect();
        chosen.sort_unstable();
        chosen
    }
}

/// A place of a large model that is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Chosen {
    /// Effects between two nodes.
    Pair([usize; 2]),
    /// Effects on a node.
    Node(usize),
    /// Effects on an element.
    Element(usize),
    /// Effects of a node's temperature on sensors.
    Surroundings(usize),
}

/// What of a model is a place.
#[derive(Default)]
pub(super) struct Among {
    pub pairs: Vec<[usize; 2]>,
    pub nodes: Vec<usize>,
    pub elements: Vec<usize>,
    /// Nodes whose temperatures effects on sensors know.
    pub surroundings: Vec<usize>,
}

impl Among {
    /// Everything that is a place without being chosen.
    pub fn of(model: &Model, limits: &Limits) -> Self {
        let count = if limits.choose_pairs(model) { 0 } else { model.nodes.len() };
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b])).collect();
        let mut nodes: Vec<usize> = (0..model.nodes.len()).collect();
        if limits.choose_members(model) {
            nodes.retain(|&node| matches!(model.nodes[node].kind, NodeKind::Boundary { .. }));
        }
        let chosen = limits.elements_to_choose(model);
        let elements = (0..model.elements.len()).filter(|element| chosen.binary_search(element).is_err()).collect();
        Self { pairs, surroundings: nodes.clone(), nodes, elements }
    }
}

impl From<Chosen> for Among {
    fn from(chosen: Chosen) -> Self {
        match chosen {
            Chosen::Pair(pair) => Self { pairs: vec![pair], ..Self::default() },
            Chosen::Node(node) => Self { nodes: vec![node], ..Self::default() },
            Chosen::Element(element) => Self { elements: vec![element], ..Self::default() },
            Chosen::Surroundings(node) => Self { surroundings: vec![node], ..Self::default() },
        }
    }
}
