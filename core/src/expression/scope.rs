//! What names mean inside an expression.

use std::collections::BTreeMap;

use super::dimension::Dimension;
use super::graph::{ExprId, Symbol};

/// Names that no parameter or input may have.
pub const RESERVED: &[&str] = &[
    "Ta",
    "Tb",
    "Tm",
    "T",
    "t",
    "sigma",
    "pi",
    "exp",
    "log",
    "sqrt",
    "sin",
    "cos",
    "tanh",
    "min",
    "max",
    "abs",
    "step",
    "smoothstep",
    "clamp",
    "interp",
];

/// Stefan-Boltzmann constant, W/(m2 K4) (CODATA 2018, exact): `sigma` in expressions.
pub const SIGMA: f64 = 5.670374419e-8;

/// The names that hold in every expression of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// Parameters and inputs: the expression that a name stands for.
    pub values: BTreeMap<String, ExprId>,
    /// Tables by name.
    pub tables: BTreeMap<String, u32>,
    /// Dimensions of symbols, where known.
    pub dimensions: BTreeMap<Symbol, Dimension>,
}

impl Names {
    /// The dimension of a symbol: temperatures are K, time s, switched states have none.
    pub fn dimension(&self, symbol: Symbol) -> Option<Dimension> {
        match symbol {
            Symbol::Node(_) => Some(Dimension::TEMPERATURE),
            Symbol::Time => Some(Dimension::TIME),
            Symbol::Mode(_) => Some(Dimension::NONE),
            Symbol::Parameter(_) | Symbol::Input(_) | Symbol::Output(_) | Symbol::Local(_) => {
                self.dimensions.get(&symbol).copied()
            }
        }
    }
}

/// The names of one expression: the model's, and local ones such as an element's temperatures.
#[derive(Clone, Debug)]
pub struct Scope<'a> {
    /// The model's names.
    pub names: &'a Names,
    /// Local names, looked up first.
    pub locals: Vec<(&'a str, ExprId)>,
}

impl<'a> Scope<'a> {
    /// The model's names alone.
    pub fn new(names: &'a Names) -> Self {
        Self { names, locals: Vec::new() }
    }

    /// With local names.
    pub fn with(names: &'a Names, locals: Vec<(&'a str, ExprId)>) -> Self {
        Self { names, locals }
    }

    /// What a name stands for.
    pub fn find(&self, name: &str) -> Option<ExprId> {
        let local = self.locals.iter().find(|(local_name, _)| *local_name == name).map(|(_, id)| *id);
        local.or_else(|| self.names.values.get(name).copied())
    }

    /// All names, local ones first.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.locals.iter().map(|(name, _)| *name).chain(self.names.values.keys().map(String::as_str))
    }
}
