//! Applying an effect to a model: elements, nodes, factors and readings, with parameters of their own.
//!
//! With all amplitudes at 0 the model's temperatures are those of before.

mod element;
mod factor;
mod node;
mod sensor;

use thiserror::Error;

use crate::expression::{ExprId, Names, Scope, Symbol, parse};
use crate::thermal::element::{Element, ElementKind};
use crate::thermal::{Limits, Model, Node, NodeKind, Parameter};

use super::checked::Effect;
use super::parameter::EffectParameter;
use super::place::{Bound, Site};

pub use node::LEAST_CAPACITY_J_PER_K;
pub use sensor::SensorChange;

/// An effect at a place of a model.
#[derive(Clone, Debug)]
pub struct Instance<'a> {
    /// Its name: its parameters are `NAME.conductance` and so on.
    pub name: &'a str,
    /// The effect.
    pub effect: &'a Effect,
    /// Where it acts.
    pub site: Site,
    /// What each input of the effect stands for, in the order of its file.
    pub bound: Vec<Bound>,
    /// Its parameters: those of [`Effect::parameters`], perhaps with other priors and nominal values.
    pub parameters: Vec<EffectParameter>,
    /// Reference temperature of its factor, K; [`REFERENCE_K`](super::REFERENCE_K) where none is stated.
    pub reference_k: f64,
    /// An input of the model that is 1 where the effect is there and 0 where not; always there without one.
    pub switch: Option<usize>,
}

/// What became of an effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Applied {
    /// Index of its first parameter in the model; the others follow.
    pub first_parameter: usize,
    /// Nodes that it added, each with the node whose start temperature it takes where none is stated.
    pub nodes: Vec<(usize, usize)>,
    /// Nodes that stored no heat before.
    pub given_storage: Vec<usize>,
    /// What becomes of sensors.
    pub sensors: Vec<SensorChange>,
}

/// An effect that cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ApplyError {
    /// A place of another kind than the effect acts on.
    #[error("the effect `{effect}` does not act on such a place")]
    Place {
        /// The effect.
        effect: String,
    },
    /// A name that the model has already.
    #[error("the model has a node `{name}` already, which the effect would add")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// An expression that does not parse.
    #[error("the effect `{effect}` has the expression `{text}`: {reason}")]
    Expression {
        /// The effect.
        effect: String,
        /// The expression.
        text: String,
        /// Why.
        reason: String,
    },
    /// A rate of something that has none.
    #[error("the rate of what sensor `{sensor}` measures is not known: {reason}")]
    NoRate {
        /// The sensor.
        sensor: String,
        /// Why.
        reason: String,
    },
}

/// Applies an effect. The model is untouched only where all is well or nothing was begun: after an error it is of no use.
///
/// # Errors
/// [`ApplyError`] says what does not fit.
pub fn apply(model: &mut Model, instance: &Instance<'_>) -> Result<Applied, ApplyError> {
    let mut names = Names::default();
    let first_parameter = model.parameters.len();
    for parameter in &instance.parameters {
        let symbol = Symbol::Parameter(u32::try_from(model.parameters.len()).unwrap_or(u32::MAX));
        let mut value = model.graph.symbol(symbol);
        if let (Some(switch), true) = (instance.switch, parameter.amplitude) {
            let present = model.graph.symbol(Bound::Input(switch).symbol());
            value = model.graph.multiply(present, value);
        }
        names.values.insert(parameter.name.clone(), value);
        model.parameters.push(Parameter {
            name: format!("{}.{}", instance.name, parameter.name),
            unit: parameter.unit.text.clone(),
            nominal: parameter.nominal,
            description: parameter.description.clone(),
            source: format!("effect {}", instance.effect.name),
        });
    }
    for (entry, bound) in instance.effect.form.inputs.iter().zip(&instance.bound) {
        let value = model.graph.symbol(bound.symbol());
        names.values.insert(entry.name.clone(), value);
        for (end, value) in ["lower", "upper"].iter().zip(bound.range(model)) {
            let number = model.graph.number(value);
            names.values.insert(format!("{}_{end}", entry.name), number);
        }
    }
    let applied = Applied { first_parameter, ..Applied::default() };
    let mut work = Work { model, instance, names, applied };
    work.elements()?;
    work.factors()?;
    work.nodes()?;
    work.sensors()?;
    Ok(work.applied)
}

/// A model that is being changed.
struct Work<'a, 'm> {
    model: &'m mut Model,
    instance: &'a Instance<'a>,
    names: Names,
    applied: Applied,
}

impl Work<'_, '_> {
    fn expression(&mut self, text: &str, locals: &[(&str, ExprId)]) -> Result<ExprId, ApplyError> {
        let scope = Scope::with(&self.names, locals.to_vec());
        parse(text, &mut self.model.graph, &scope).map_err(|error| ApplyError::Expression {
            effect: self.instance.effect.name.clone(),
            text: text.to_owned(),
            reason: error.message,
        })
    }

    /// The error of a place that does not fit.
    fn misplaced(&self) -> ApplyError {
        ApplyError::Place { effect: self.instance.effect.name.clone() }
    }

    fn temperature(&mut self, node: usize) -> ExprId {
        self.model.graph.symbol(Bound::Node(node).symbol())
    }

    /// `Ta`, `Tb` and `Tm` of two nodes.
    fn ends(&mut self, [a, b]: [usize; 2]) -> [(&'static str, ExprId); 3] {
        let (ta, tb) = (self.temperature(a), self.temperature(b));
        let sum = self.model.graph.add(ta, tb);
        let half = self.model.graph.number(0.5);
        let mean = self.model.graph.multiply(half, sum);
        [("Ta", ta), ("Tb", tb), ("Tm", mean)]
    }

    fn weighted(&mut self, value: ExprId, weight: f64) -> ExprId {
        let weight = self.model.graph.number(weight);
        self.model.graph.multiply(weight, value)
    }

    /// The value, at least `floor`.
    fn at_least(&mut self, value: ExprId, floor: f64) -> ExprId {
        let floor = self.model.graph.number(floor);
        self.model.graph.binary(crate::expression::Binary::Maximum, value, floor)
    }

    /// Adds an element; with several members its name tells which.
    fn add_element(&mut self, member: Option<usize>, kind: ElementKind) {
        let name = self.member_name(self.instance.name, member);
        self.model.elements.push(Element { name, kind });
    }

    fn member_name(&self, name: &str, member: Option<usize>) -> String {
        match member {
            Some(node) => format!("{name} ({})", self.model.nodes[node].name),
            None => name.to_owned(),
        }
    }

    /// Adds a node `NAME.what`; with several members its name tells which.
    fn add_node(&mut self, what: &str, member: Option<usize>, kind: NodeKind) -> Result<usize, ApplyError> {
        let name = self.member_name(&format!("{}.{what}", self.instance.name), member);
        if self.model.nodes.iter().any(|node| node.name == name) {
            return Err(ApplyError::NameTaken { name });
        }
        self.model.nodes.push(Node { name, kind, area: None, alias: None, limits: Limits::default() });
        Ok(self.model.nodes.len() - 1)
    }

    /// Nodes of the place with weights, each with itself where there are several.
    fn place_nodes(&self) -> Result<Vec<(usize, f64, Option<usize>)>, ApplyError> {
        let Site::Nodes(nodes) = &self.instance.site else { return Err(self.misplaced()) };
        let several = nodes.len() > 1;
        Ok(nodes.iter().map(|&(node, weight)| (node, weight, several.then_some(node))).collect())
    }

    /// Elements of the place.
    fn place_elements(&self) -> Result<Vec<usize>, ApplyError> {
        match &self.instance.site {
            Site::Elements(elements) => Ok(elements.to_vec()),
            _ => Err(self.misplaced()),
        }
    }
}
