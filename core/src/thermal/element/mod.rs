//! Elements of the network, a kind a file. An element says, as expressions, what heat flows into which node;
//! the network adds them up, differentiates and compiles them. A new kind is a file here and a line below.

pub mod conductor;
pub mod cooler;
pub mod flow;
pub mod heater;
pub mod law;
pub mod load;
pub mod radiation;

use crate::expression::{ExprId, Graph};

pub use conductor::Conductor;
pub use cooler::Cooler;
pub use flow::Flow;
pub use heater::{Heater, HeaterControl};
pub use law::Law;
pub use load::Load;
pub use radiation::Radiation;

/// Stefan-Boltzmann constant, W/(m2 K4) (CODATA 2018, exact).
pub const STEFAN_BOLTZMANN: f64 = 5.670374419e-8;

/// An element with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Name, unique within its kind.
    pub name: String,
    /// What it is.
    pub kind: ElementKind,
}

/// The kinds of element.
#[derive(Clone, Debug, PartialEq)]
pub enum ElementKind {
    /// Linear conductor.
    Conductor(Conductor),
    /// Radiative exchange.
    Radiation(Radiation),
    /// Heat into a node.
    Load(Load),
    /// Any heat flow between two nodes.
    Flow(Flow),
    /// Thermoelectric cooler.
    Cooler(Cooler),
    /// Controlled heater.
    Heater(Heater),
}

/// What an element does to the network, as expressions in the network's graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contribution {
    /// Heat into nodes, W: `(node, heat)`.
    pub heat: Vec<(usize, ExprId)>,
    /// Size of the terms that cancel in the balance, W: the sum of `|G T|` and `|sigma GR T^4|` terms by node.
    pub magnitude: Vec<(usize, ExprId)>,
    /// The quantity `{"heat": NAME}`, W, from the first to the second end (or into the node).
    pub through: Option<ExprId>,
    /// The quantity `{"current": NAME}`, A.
    pub current: Option<ExprId>,
    /// The quantity `{"duty": NAME}`, 1.
    pub duty: Option<ExprId>,
    /// Width of a controller's band, K: must be above 0.
    pub band: Option<ExprId>,
}

impl Element {
    /// Whether the element has two states in a transient (a thermostat).
    pub fn is_switched(&self) -> bool {
        matches!(&self.kind, ElementKind::Heater(heater) if matches!(heater.control, HeaterControl::Thermostat { .. }))
    }

    /// The element's expressions. `switched` asks for the form with `Symbol::Mode` of a transient (thermostats);
    /// otherwise the steady form.
    pub fn contribution(&self, graph: &mut Graph, modes: &mut Vec<heater::Switch>, switched: bool) -> Contribution {
        match &self.kind {
            ElementKind::Conductor(element) => element.contribution(graph),
            ElementKind::Radiation(element) => element.contribution(graph),
            ElementKind::Load(element) => element.contribution(graph),
            ElementKind::Flow(element) => element.contribution(graph),
            ElementKind::Cooler(element) => element.contribution(graph),
            ElementKind::Heater(element) => element.contribution(graph, modes, switched),
        }
    }
}
