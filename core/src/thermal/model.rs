//! A thermal model, resolved: SI units, names replaced by indices, expressions parsed.

use std::sync::OnceLock;

use crate::expression::{ExprId, Graph, Symbol, Term};

use super::clock::Clocks;
use super::element::Element;
use super::external::External;
use super::size::Size;

/// A resolved model. Expressions live in `graph`; `Symbol::Parameter(i)`, `Symbol::Input(i)` and
/// `Symbol::Node(i)` index the lists below, `Symbol::Output(i)` the outputs of what answers for it.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Title, for people.
    pub title: String,
    /// The expressions.
    pub graph: Graph,
    /// Parameters in the order of the file, adopted effects' after the model's.
    pub parameters: Vec<Parameter>,
    /// Inputs in the order of the file.
    pub inputs: Vec<Input>,
    /// Inputs that say when, where there are any: what changes at a time depends on them and on the time that has passed.
    pub clocks: Clocks,
    /// Inputs that are 1 where an adopted effect is there: none that physics follows.
    pub switches: Vec<usize>,
    /// Nodes in the order of the file, boundaries included.
    pub nodes: Vec<Node>,
    /// Elements: conductors, radiations, loads, flows, coolers, heaters, surface coolers, each in the order of the file.
    pub elements: Vec<Element>,
    /// Named quantities, in the order of the file.
    pub quantities: Vec<Quantity>,
    /// What answers for the model in place of nodes and elements.
    pub external: Option<External>,
    /// Whether a conductance or the like below 0 ([`super::element::SignConstraint`]) is an error where the model is solved. Where
    /// effects are tried, either sign tells something.
    pub keeps_signs: bool,
    /// Its size when that was first asked for: what effects add to it does not change what it is to them.
    pub size: OnceLock<Size>,
}

impl Model {
    /// The node whose temperature a quantity is.
    pub fn node_of(&self, quantity: usize) -> Option<usize> {
        let QuantityValue::Instant(value) = self.quantities[quantity].value else { return None };
        match self.graph.term(value) {
            Term::Symbol(Symbol::Node(node)) => Some(node as usize),
            _ => None,
        }
    }

    /// How large its hardware is.
    pub fn size(&self) -> Size {
        *self.size.get_or_init(|| Size::of(self))
    }
}

/// A parameter's name and nominal value; its prior belongs to inference.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, such as `G_bi` or `harness.conductance`.
    pub name: String,
    /// Unit as written in the file, for people.
    pub unit: String,
    /// Nominal value, SI.
    pub nominal: f64,
    /// Description for the report.
    pub description: String,
    /// Where the value comes from.
    pub source: String,
}

/// An input: a boundary temperature, a dissipation, an environment.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Name.
    pub name: String,
    /// Unit as written in the file, for people.
    pub unit: String,
    /// Nominal value, SI.
    pub nominal: f64,
    /// Stated range, SI.
    pub range: Option<[f64; 2]>,
    /// Whether a test can set it.
    pub settable: bool,
    /// Description for the report.
    pub description: String,
}

/// What a node's temperature follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeKind {
    /// Stores heat; capacity in J/K, may depend on parameters, inputs and this node's temperature.
    Diffusion {
        /// Heat capacity, J/K.
        capacity: ExprId,
    },
    /// Stores no heat: its balance closes at every instant.
    Arithmetic,
    /// Has a given temperature, K; depends on parameters, inputs and time only.
    Boundary {
        /// Temperature, K.
        temperature: ExprId,
    },
}

/// A component's temperature limits, K.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Limits {
    /// Caution limits.
    pub yellow: Option<[f64; 2]>,
    /// Limits that must not be exceeded.
    pub red: Option<[f64; 2]>,
}

/// A node of the network.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Boundary, diffusion or arithmetic.
    pub kind: NodeKind,
    /// Surface area, m2.
    pub area: Option<f64>,
    /// Name or number in another tool.
    pub alias: Option<String>,
    /// Temperature limits.
    pub limits: Limits,
}

/// How a quantity is had from the temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QuantityValue {
    /// An expression over parameters, inputs, time and node temperatures.
    Instant(ExprId),
    /// The largest value of an expression over a transient.
    Maximum(ExprId),
    /// The smallest value over a transient.
    Minimum(ExprId),
    /// The time average over a transient.
    TimeMean(ExprId),
}

impl QuantityValue {
    /// The expression at an instant.
    pub fn expression(self) -> ExprId {
        match self {
            Self::Instant(id) | Self::Maximum(id) | Self::Minimum(id) | Self::TimeMean(id) => id,
        }
    }
}

/// Something that is asked of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// SI unit, for people: `K`, `W`, `A`, `1`, ...
    pub unit: String,
    /// Whether it is an absolute temperature (shown in degC where the study writes degC).
    pub is_temperature: bool,
    /// How it is had.
    pub value: QuantityValue,
}

impl Quantity {
    /// What is wrong with a value of it, in words; nothing where the value is a finite number.
    pub fn fault(&self, value: f64) -> Option<String> {
        (!value.is_finite()).then(|| format!("quantity `{}` is {value}", self.name))
    }
}
