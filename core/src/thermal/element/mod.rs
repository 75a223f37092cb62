//! Elements of the network, a kind a file. An element says, as expressions, what heat flows into which node;
//! the network adds them up, differentiates and compiles them. A new kind is a file here, which answers [`Physics`] and
//! [`ElementForm`] (how it is written in a model's file), and an entry in the list below.

pub mod drawing;
pub mod form;
pub mod sign;

use serde_json::{Value, json};

use crate::expression::{ExprId, Graph};

pub use cooler::Drive;
pub use drawing::{Drawing, Path, Source};
pub use form::{ElementForm, Lookup};
pub use heater::{HeaterControl, Switch};
pub use sign::SignConstraint;

/// Stefan-Boltzmann constant, W/(m2 K4) (CODATA 2018, to ten digits).
pub const STEFAN_BOLTZMANN: f64 = 5.670374419e-8;

/// Evaluates an expression at nominal parameters and inputs, all nodes at one temperature, one of them warmer by 1 K.
pub type At<'a> = dyn Fn(ExprId, Option<usize>) -> f64 + 'a;

/// What a kind of element answers.
pub trait Physics {
    /// The kind in a word: `conductor`.
    fn kind(&self) -> &'static str;
    /// The element's expressions. `switched` asks for the form with `Symbol::Mode` of a transient (thermostats), whose
    /// switches are added to `switches`; otherwise the steady form.
    fn contribution(&self, graph: &mut Graph, switches: &mut Vec<Switch>, switched: bool) -> Contribution;
    /// What decides a result, as JSON; `number` writes an expression down.
    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value;
    /// The element in a table.
    fn description(&self, name: &dyn Fn(usize) -> String) -> Description;
    /// How it is drawn.
    fn drawing(&self) -> Drawing;

    /// Ends and conductance, W/K, of a path along which heat goes with the difference of the temperatures.
    fn linear_path(&self) -> Option<([usize; 2], ExprId)> {
        None
    }

    /// The nodes that it joins, each with the next; none of an element that heats one.
    fn joined(&self) -> &[usize] {
        &[]
    }
    /// The node that it heats.
    fn heated(&self) -> Option<usize> {
        None
    }
    /// The two nodes between which heat flows by their temperatures alone.
    fn between(&self) -> Option<[usize; 2]> {
        None
    }
    /// Whether it is a path and no more: a conductance or an exchange area between two nodes.
    fn is_passive(&self) -> bool {
        false
    }
    /// The two nodes, to be changed.
    fn between_mut(&mut self) -> Option<&mut [usize; 2]> {
        None
    }
    /// The node whose temperature its own heat fixes where nothing else does.
    fn anchored(&self, _graph: &Graph) -> Option<usize> {
        None
    }
    /// Conductance between its two nodes, linearised, W/K.
    fn conductance(&self, _at: &At<'_>) -> Option<f64> {
        None
    }
    /// Its values that must have a sign. Heats have a direction instead.
    fn sign_constraints(&self) -> Vec<SignConstraint> {
        Vec::new()
    }
    /// What a factor changes: conductance, exchange area, power.
    fn scaled(&mut self) -> Option<&mut ExprId> {
        None
    }
    /// What is wrong with how it is made.
    fn fault(&self) -> Option<String> {
        None
    }
    /// Whether it has two states in a transient (a thermostat).
    fn is_switched(&self) -> bool {
        false
    }
}

/// An element in a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What it does: `conduction`.
    pub what: &'static str,
    /// Its nodes, in words.
    pub ends: String,
    /// What says how large it is.
    pub value: ExprId,
    /// SI unit of that.
    pub unit: &'static str,
    /// Other expressions that it is made of.
    pub others: Vec<ExprId>,
}

/// From one node to the next, in words.
pub(super) fn arrows(nodes: &[usize], name: &dyn Fn(usize) -> String) -> String {
    nodes.iter().map(|&node| name(node)).collect::<Vec<_>>().join(" \u{2192} ")
}

/// Hands the kinds to another macro, each with the field of a model's form, its type, its form and its module. The
/// documentation describes the field in the schema.
#[macro_export]
macro_rules! element_kinds {
    ($use_them:ident) => {
        $use_them! {
            /// Linear conductors: heat a to b = conductance (Ta - Tb).
            conductors: Conductor, ConductorForm in conductor,
            /// Radiative exchange: heat a to b = sigma exchange_area (Ta^4 - Tb^4).
            radiations: Radiation, RadiationForm in radiation,
            /// Heat into nodes.
            loads: Load, LoadForm in load,
            /// Any heat flow between two nodes.
            flows: Flow, FlowForm in flow,
            /// Thermoelectric coolers.
            coolers: Cooler, CoolerForm in cooler,
            /// Controlled heaters.
            heaters: Heater, HeaterForm in heater,
            /// Thermoelectric coolers as response surfaces: temperature of the cold side and current over voltage and hot side.
            surface_coolers: SurfaceCooler, SurfaceCoolerForm in surface_cooler,
        }
    };
}
pub use element_kinds;

/// Declares the kinds: a module each, a variant, an arm.
macro_rules! declare {
    ($( #[doc = $doc:literal] $field:ident: $kind:ident, $form:ident in $module:ident, )*) => {
        $( pub mod $module; pub use $module::{$form, $kind}; )*

        /// The kinds of element.
        #[derive(Clone, Debug, PartialEq)]
        pub enum ElementKind {
            $( #[doc = $doc] $kind($kind) ),*
        }

        impl ElementKind {
            /// What the kind answers.
            pub fn physics(&self) -> &dyn Physics {
                match self { $( Self::$kind(element) => element ),* }
            }

            /// The same, to be changed.
            pub fn physics_mut(&mut self) -> &mut dyn Physics {
                match self { $( Self::$kind(element) => element ),* }
            }
        }
    };
}

element_kinds!(declare);

/// An element with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Name, unique within its kind.
    pub name: String,
    /// What it is.
    pub kind: ElementKind,
}

/// What an element does to the network, as expressions in the network's graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contribution {
    /// Heat into nodes, W: `(node, heat)`.
    pub heat: Vec<(usize, ExprId)>,
    /// Size of the terms that cancel in the balance, W: the sum of `|G T|` and `|sigma GR T^4|` terms by node.
    pub balance_scale: Vec<(usize, ExprId)>,
    /// The quantity `{"heat": NAME}`, W, from the first to the second end (or into the node).
    pub through: Option<ExprId>,
    /// The quantity `{"current": NAME}`, A.
    pub current: Option<ExprId>,
    /// The quantity `{"cold_side": NAME}`, K, of a cooler whose cold side is no node.
    pub cold_side: Option<ExprId>,
    /// The quantity `{"duty": NAME}`, 1.
    pub duty: Option<ExprId>,
    /// Width of a controller's band, K: must be above 0.
    pub band: Option<ExprId>,
}

impl Element {
    /// What its kind answers.
    pub fn physics(&self) -> &dyn Physics {
        self.kind.physics()
    }

    /// As [`Physics::contribution`].
    pub fn contribution(&self, graph: &mut Graph, switches: &mut Vec<Switch>, switched: bool) -> Contribution {
        self.physics().contribution(graph, switches, switched)
    }

    /// As [`Physics::identity`], under its name.
    pub fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        let physics = self.physics();
        json!({"name": self.name, "element": {physics.kind(): physics.identity(number)}})
    }

    /// The nodes that it joins or heats, not one that its controller only senses.
    pub fn nodes(&self) -> Vec<usize> {
        let physics = self.physics();
        physics.joined().iter().copied().chain(physics.heated()).collect()
    }
}
