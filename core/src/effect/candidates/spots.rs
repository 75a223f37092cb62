//! The places of a model where an effect could be.

use crate::effect::candidate::{GROUP, GroupPlace};
use crate::effect::checked::Effect;
use crate::effect::place::{Bound, PlaceKind, SensorPlace, Site};
use crate::expression::Term;
use crate::thermal::{Model, NodeKind};

use super::limits::Among;

/// A place before what its inputs stand for is chosen.
pub(super) struct Spot {
    pub kind: &'static str,
    pub names: Vec<String>,
    pub site: Site,
    /// Nodes that may stand for an input that is a temperature.
    pub nodes: Vec<usize>,
}

/// The places of an effect among these.
pub(super) fn spots(
    effect: &Effect,
    model: &Model,
    groups: &[GroupPlace],
    sensors: &[SensorPlace],
    among: &Among,
) -> Vec<Spot> {
    let mut spots = Vec::new();
    let name = |node: usize| model.nodes[node].name.clone();
    for &kind in &effect.places {
        let mut put = |names: Vec<String>, site: Site, nodes: Vec<usize>| {
            spots.push(Spot { kind: kind.where_kind(), names, site, nodes });
        };
        match kind {
            PlaceKind::Pair => {
                for &[a, b] in &among.pairs {
                    let given = |node: usize| matches!(model.nodes[node].kind, NodeKind::Boundary { .. });
                    if given(a) && given(b) {
                        continue;
                    }
                    let ends = if name(a) <= name(b) { [a, b] } else { [b, a] };
                    put(ends.map(name).to_vec(), Site::Pair(ends), ends.to_vec());
                }
            }
            PlaceKind::Node | PlaceKind::Boundary | PlaceKind::Capacity => {
                for &node in among.nodes.iter().filter(|node| kind.is_node(&model.nodes[**node].kind)) {
                    put(vec![name(node)], Site::Nodes([(node, 1.0)].into()), vec![node]);
                }
            }
            PlaceKind::Sensor => {
                for sensor in sensors.iter().filter(|sensor| effect.fits_sensor(model, sensor)) {
                    let all = among.surroundings.iter().copied();
                    let others = all.filter(|&node| !is_temperature_of(model, sensor, node)).collect();
                    put(vec![sensor.name.clone()], Site::Sensors(vec![sensor.clone()]), others);
                }
            }
            PlaceKind::SensorPair => {
                for (position, a) in sensors.iter().enumerate() {
                    for b in &sensors[position + 1..] {
                        let unit = |sensor: &SensorPlace| model.quantities.get(sensor.quantity).map(|q| &q.unit);
                        if unit(a) == unit(b) {
                            let (a, b) = if a.name <= b.name { (a, b) } else { (b, a) };
                            let names = vec![a.name.clone(), b.name.clone()];
                            put(names, Site::Sensors(vec![a.clone(), b.clone()]), Vec::new());
                        }
                    }
                }
            }
            _ => {
                for &index in among.elements.iter().filter(|index| kind.is_element(&model.elements[**index])) {
                    let element = &model.elements[index];
                    put(vec![element.name.clone()], Site::Elements([index].into()), element.nodes());
                }
            }
        }
    }
    if effect.groups {
        let fitting = groups.iter().filter(|group| effect.fits_group(model, &group.site));
        spots.extend(fitting.map(|group| Spot {
            kind: GROUP,
            names: vec![group.name.clone()],
            site: group.site.clone(),
            nodes: Vec::new(),
        }));
    }
    spots
}

fn is_temperature_of(model: &Model, sensor: &SensorPlace, node: usize) -> bool {
    let symbol = Bound::Node(node).symbol();
    model
        .quantities
        .get(sensor.quantity)
        .is_some_and(|quantity| model.graph.term(quantity.value.expression()) == Term::Symbol(symbol))
}

impl Effect {
    /// Whether a sensor's law fits what it measures: an amplitude in K, or none with a unit.
    pub fn fits_sensor(&self, model: &Model, sensor: &SensorPlace) -> bool {
        let Some(quantity) = model.quantities.get(sensor.quantity) else { return false };
        let per_temperature = self.form.adds.value.reading.is_some()
            && self.form.parameters.iter().any(|entry| {
                !entry.value.shape && entry.value.unit.as_ref().is_some_and(|written| !written.unit.dimension.is_none())
            });
        quantity.is_temperature || !per_temperature
    }

    /// Whether members of a group are places of this effect.
    pub fn fits_group(&self, model: &Model, site: &Site) -> bool {
        self.groups
            && self.places.iter().any(|&kind| match site {
                Site::Nodes(nodes) => nodes.iter().all(|&(node, _)| kind.is_node(&model.nodes[node].kind)),
                Site::Elements(elements) => elements.iter().all(|&element| kind.is_element(&model.elements[element])),
                Site::Sensors(sensors) => {
                    kind == PlaceKind::Sensor && sensors.iter().all(|sensor| self.fits_sensor(model, sensor))
                }
                Site::Pair(_) | Site::Parameter(_) => false,
            })
    }
}
