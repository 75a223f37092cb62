//! Where an effect acts: kinds of place, and places of a model.

use std::sync::Arc;

use crate::expression::{Dimension, Symbol, Unit};
use crate::thermal::element::Element;
use crate::thermal::{Model, NodeKind};

/// Kinds of place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceKind {
    /// Two nodes, unordered.
    Pair,
    /// A node that is no boundary.
    Node,
    /// A boundary node.
    Boundary,
    /// A conductor.
    Conductor,
    /// A radiation.
    Radiation,
    /// A load.
    Load,
    /// The heat capacity of a node that has one.
    Capacity,
    /// A controlled heater.
    Heater,
    /// A thermoelectric cooler.
    Cooler,
    /// A sensor.
    Sensor,
    /// Two sensors.
    SensorPair,
}

impl PlaceKind {
    /// All kinds.
    pub const ALL: &[Self] = &[
        Self::Pair,
        Self::Node,
        Self::Boundary,
        Self::Conductor,
        Self::Radiation,
        Self::Load,
        Self::Capacity,
        Self::Heater,
        Self::Cooler,
        Self::Sensor,
        Self::SensorPair,
    ];

    /// As in an effect's file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pair => "pair",
            Self::Node => "node",
            Self::Boundary => "boundary",
            Self::Conductor => "conductor",
            Self::Radiation => "radiation",
            Self::Load => "load",
            Self::Capacity => "capacity",
            Self::Heater => "heater",
            Self::Cooler => "cooler",
            Self::Sensor => "sensor",
            Self::SensorPair => "sensor_pair",
        }
    }

    /// As in a result's `where_kind`.
    pub fn where_kind(self) -> &'static str {
        match self {
            Self::Pair => "nodes",
            Self::SensorPair => "sensors",
            other => other.word(),
        }
    }

    /// How many names stand for such a place.
    pub fn names(self) -> usize {
        if matches!(self, Self::Pair | Self::SensorPair) { 2 } else { 1 }
    }

    /// Whether it has two ends.
    pub fn has_ends(self) -> bool {
        matches!(self, Self::Pair | Self::Conductor | Self::Radiation | Self::Cooler)
    }

    /// Whether its places are elements.
    pub fn is_of_elements(self) -> bool {
        matches!(self, Self::Conductor | Self::Radiation | Self::Load | Self::Heater | Self::Cooler)
    }

    /// Whether an element is a place of this kind.
    pub fn is_element(self, element: &Element) -> bool {
        self.word() == element.physics().kind()
    }

    /// Whether a node is a place of this kind.
    pub fn is_node(self, kind: &NodeKind) -> bool {
        match self {
            Self::Node => !matches!(kind, NodeKind::Boundary { .. }),
            Self::Boundary => matches!(kind, NodeKind::Boundary { .. }),
            Self::Capacity => matches!(kind, NodeKind::Diffusion { .. }),
            _ => false,
        }
    }
}

/// A sensor as an effect sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPlace {
    /// Its name in the measurements.
    pub name: String,
    /// Index of the quantity that it measures.
    pub quantity: usize,
    /// Whether it takes part in a steady measurement.
    pub steady: bool,
    /// Whether it takes part in a transient.
    pub transient: bool,
}

/// A place of a model, by indices. Those of large groups are shared by all candidates there.
#[derive(Clone, Debug, PartialEq)]
pub enum Site {
    /// Two nodes.
    Pair([usize; 2]),
    /// Nodes with weights: one of weight 1, or a group.
    Nodes(Arc<[(usize, f64)]>),
    /// Elements of one kind: one, or a group.
    Elements(Arc<[usize]>),
    /// Sensors: one, a group, or two whose channels are exchanged.
    Sensors(Vec<SensorPlace>),
    /// A parameter of the model. No effect of a catalogue acts there; its prior may be wrong.
    Parameter(usize),
}

/// What an input of an effect stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// An input of the model.
    Input(usize),
    /// A node's temperature.
    Node(usize),
}

/// Temperatures between which a function of a node's temperature is resolved, K.
pub const TEMPERATURE_RANGE_K: [f64; 2] = [200.0, 400.0];

impl Bound {
    /// Its symbol.
    pub fn symbol(self) -> Symbol {
        match self {
            Self::Input(index) => Symbol::Input(u32::try_from(index).unwrap_or(u32::MAX)),
            Self::Node(index) => Symbol::Node(u32::try_from(index).unwrap_or(u32::MAX)),
        }
    }

    /// Its dimension, where known.
    pub fn dimension(self, model: &Model) -> Option<Dimension> {
        match self {
            Self::Node(_) => Some(Dimension::TEMPERATURE),
            Self::Input(index) => Unit::parse(&model.inputs[index].unit).ok().map(|unit| unit.dimension),
        }
    }

    /// Its range, SI: the stated one, or round the nominal value where there is none.
    pub fn range(self, model: &Model) -> [f64; 2] {
        match self {
            Self::Node(_) => TEMPERATURE_RANGE_K,
            Self::Input(index) => {
                let input = &model.inputs[index];
                let room = if input.nominal == 0.0 { 1.0 } else { 0.5 * input.nominal.abs() };
                input.range.unwrap_or([input.nominal - room, input.nominal + room])
            }
        }
    }

    /// Whether it is an input that says when.
    pub fn is_clock(self, model: &Model) -> bool {
        matches!(self, Self::Input(input) if model.clocks.has(input))
    }

    /// Whether it is an input whose unit is one of angles.
    pub fn is_angle(self, model: &Model) -> bool {
        match self {
            Self::Node(_) => false,
            Self::Input(index) => Unit::parse(&model.inputs[index].unit).is_ok_and(|unit| unit.is_angle()),
        }
    }

    /// Its largest magnitude in its range, SI; 1 where that is 0.
    pub fn largest(self, model: &Model) -> f64 {
        let [lower, upper] = self.range(model);
        let largest = lower.abs().max(upper.abs());
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// Its name in the model.
    pub fn name(self, model: &Model) -> &str {
        match self {
            Self::Input(index) => &model.inputs[index].name,
            Self::Node(index) => &model.nodes[index].name,
        }
    }
}
