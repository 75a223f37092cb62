//! Additions that store heat or stand between: capacities, hidden nodes, a node inside a conductor or behind a load, a contact.

use crate::thermal::NodeKind;
use crate::thermal::element::{Conductor, ElementKind, Heater, Load};

use super::{ApplyError, Work};
use crate::effect::place::Site;

/// Smallest capacity of a node that an effect adds, J/K: it exists while the amplitude is 0.
pub const LEAST_CAPACITY_J_PER_K: f64 = 1e-6;
/// Smallest conductance of a path that an effect adds, W/K: far below what any measurement shows.
const LEAST_CONDUCTANCE_W_PER_K: f64 = 1e-12;
/// Smallest resistance of a contact, K/W: 1 W makes a microkelvin.
const LEAST_RESISTANCE_K_PER_W: f64 = 1e-6;

impl Work<'_, '_> {
    /// `capacity`, `node`, `within`, `source` and `contact`.
    pub(super) fn nodes(&mut self) -> Result<(), ApplyError> {
        let adds = &self.instance.effect.form.adds.value;
        if let Some(capacity) = &adds.capacity {
            for (node, weight, _) in self.place_nodes()? {
                let temperature = self.temperature(node);
                let more = self.expression(&capacity.value, &[("T", temperature)])?;
                let more = self.weighted(more, weight);
                let capacity = match self.model.nodes[node].kind {
                    NodeKind::Diffusion { capacity } => self.model.graph.add(capacity, more),
                    NodeKind::Arithmetic => {
                        self.applied.given_storage.push(node);
                        self.at_least(more, LEAST_CAPACITY_J_PER_K)
                    }
                    NodeKind::Boundary { .. } => return Err(self.misplaced()),
                };
                self.model.nodes[node].kind = NodeKind::Diffusion { capacity };
            }
        }
        if let Some(node) = &adds.node {
            self.hidden(&node.capacity.value, &node.conductance.value)?;
        }
        if let Some(within) = &adds.within {
            for element in self.place_elements()? {
                self.within(element, &within.capacity.value, &within.share.value)?;
            }
        }
        if let Some(source) = &adds.source {
            for element in self.place_elements()? {
                self.source(element, &source.capacity.value, &source.conductance.value)?;
            }
        }
        if let Some(contact) = &adds.contact {
            for element in self.place_elements()? {
                self.contact(element, &contact.value)?;
            }
        }
        Ok(())
    }

    fn hidden(&mut self, capacity: &str, conductance: &str) -> Result<(), ApplyError> {
        let path = self.expression(conductance, &[])?;
        let path = self.at_least(path, LEAST_CONDUCTANCE_W_PER_K);
        let places: Vec<(Vec<usize>, f64, f64, Option<usize>)> = match &self.instance.site {
            // Two halves in series make the path.
            Site::Pair(ends) => vec![(ends.to_vec(), 1.0, 2.0, None)],
            _ => {
                let nodes = self.place_nodes()?;
                nodes.into_iter().map(|(node, weight, member)| (vec![node], weight, weight, member)).collect()
            }
        };
        for (neighbours, capacity_weight, path_weight, member) in places {
            let node = self.add_node("hidden", member, NodeKind::Arithmetic)?;
            let temperature = self.temperature(node);
            let value = self.expression(capacity, &[("T", temperature)])?;
            let value = self.weighted(value, capacity_weight);
            let value = self.at_least(value, LEAST_CAPACITY_J_PER_K);
            self.model.nodes[node].kind = NodeKind::Diffusion { capacity: value };
            let conductance = self.weighted(path, path_weight);
            for &neighbour in &neighbours {
                let between = [neighbour, node];
                let member = if neighbours.len() > 1 { Some(neighbour) } else { member };
                self.add_element(member, ElementKind::Conductor(Conductor { between, conductance }));
            }
            self.applied.nodes.extend(self.host(&neighbours).map(|host| (node, host)));
        }
        Ok(())
    }

    /// Cuts a conductor in two with a node between: `G / s` before it and `G / (1 - s)` behind, in series `G`.
    fn within(&mut self, element: usize, capacity: &str, share: &str) -> Result<(), ApplyError> {
        let ElementKind::Conductor(Conductor { between: [a, b], conductance }) = self.model.elements[element].kind
        else {
            return Err(self.misplaced());
        };
        let capacity = self.expression(capacity, &[])?;
        let capacity = self.at_least(capacity, LEAST_CAPACITY_J_PER_K);
        let several = matches!(&self.instance.site, Site::Elements(elements) if elements.len() > 1);
        let what =
            if several { format!("hidden ({})", self.model.elements[element].name) } else { "hidden".to_owned() };
        let node = self.add_node(&what, None, NodeKind::Diffusion { capacity })?;
        let share = self.expression(share, &[])?;
        let one = self.model.graph.number(1.0);
        let rest = self.model.graph.subtract(one, share);
        let before = self.model.graph.divide(conductance, share);
        let behind = self.model.graph.divide(conductance, rest);
        self.change_element(element, |_, kind| {
            *kind = ElementKind::Conductor(Conductor { between: [a, node], conductance: before });
            Ok(())
        })?;
        self.add_element(
            several.then_some(node),
            ElementKind::Conductor(Conductor { between: [node, b], conductance: behind }),
        );
        self.applied.nodes.extend(self.host(&[a, b]).map(|host| (node, host)));
        Ok(())
    }

    /// Lets a load or heater heat a node of its own, which a path joins to the node that was heated.
    fn source(&mut self, element: usize, capacity: &str, conductance: &str) -> Result<(), ApplyError> {
        let physics = self.model.elements[element].physics();
        let Some(heated) = physics.heated() else { return Err(self.misplaced()) };
        let capacity = self.expression(capacity, &[])?;
        let capacity = self.at_least(capacity, LEAST_CAPACITY_J_PER_K);
        let conductance = self.expression(conductance, &[])?;
        let several = matches!(&self.instance.site, Site::Elements(elements) if elements.len() > 1);
        let what =
            if several { format!("hidden ({})", self.model.elements[element].name) } else { "hidden".to_owned() };
        let node = self.add_node(&what, None, NodeKind::Diffusion { capacity })?;
        self.change_element(element, |work, kind| match kind {
            ElementKind::Load(Load { into, .. }) | ElementKind::Heater(Heater { into, .. }) => {
                *into = node;
                Ok(())
            }
            _ => Err(work.misplaced()),
        })?;
        let between = [node, heated];
        self.add_element(several.then_some(node), ElementKind::Conductor(Conductor { between, conductance }));
        self.applied.nodes.push((node, heated));
        Ok(())
    }

    /// The neighbour whose start temperature an added node takes: no boundary, which has none.
    fn host(&self, neighbours: &[usize]) -> Option<usize> {
        let is_given = |node: usize| matches!(self.model.nodes[node].kind, NodeKind::Boundary { .. });
        neighbours.iter().copied().find(|&node| !is_given(node)).or(neighbours.first().copied())
    }

    /// Puts a node without storage between a cooler's hot side and its node.
    fn contact(&mut self, element: usize, resistance: &str) -> Result<(), ApplyError> {
        let ElementKind::Cooler(cooler) = &self.model.elements[element].kind else { return Err(self.misplaced()) };
        let Some(&hot) = cooler.nodes.last() else { return Err(self.misplaced()) };
        let resistance = self.expression(resistance, &[])?;
        let resistance = self.at_least(resistance, LEAST_RESISTANCE_K_PER_W);
        let one = self.model.graph.number(1.0);
        let conductance = self.model.graph.divide(one, resistance);
        let several = matches!(&self.instance.site, Site::Elements(elements) if elements.len() > 1);
        let side = self.add_node("hot side", several.then_some(hot), NodeKind::Arithmetic)?;
        self.change_element(element, |work, kind| {
            let ElementKind::Cooler(cooler) = kind else { return Err(work.misplaced()) };
            if let Some(last) = cooler.nodes.last_mut() {
                *last = side;
            }
            Ok(())
        })?;
        self.add_element(
            several.then_some(side),
            ElementKind::Conductor(Conductor { between: [side, hot], conductance }),
        );
        self.applied.nodes.push((side, hot));
        Ok(())
    }
}
