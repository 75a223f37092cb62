//! The dimension of an expression, as far as it can be known.
//!
//! A number in an expression may carry a unit that only its author knows (`0.045` may be an area). So a number
//! fits any sum, and a product with one is unknown: what is reported is a clash between named things only.

use std::collections::HashMap;

use super::dimension::Dimension;
use super::graph::{Binary, ExprId, Graph, Symbol, Term, Unary};

/// What is known of a dimension; `None`: nothing.
pub type Inferred = Option<Dimension>;

/// Works out the dimension of an expression, where `symbol` tells that of symbols and `dimensions` that of some terms;
/// clashes inside it are described in `clashes`.
pub fn infer(
    graph: &Graph,
    root: ExprId,
    symbol: &dyn Fn(Symbol) -> Option<Dimension>,
    dimensions: &[(ExprId, Dimension)],
    clashes: &mut Vec<String>,
) -> Inferred {
    let dimensions = dimensions.iter().map(|&(id, dimension)| (id, Some(dimension))).collect();
    Walk { graph, symbol, dimensions, clashes }.of(root)
}

struct Walk<'a> {
    graph: &'a Graph,
    symbol: &'a dyn Fn(Symbol) -> Option<Dimension>,
    dimensions: HashMap<ExprId, Inferred>,
    clashes: &'a mut Vec<String>,
}

impl Walk<'_> {
    fn of(&mut self, id: ExprId) -> Inferred {
        if let Some(&inferred) = self.dimensions.get(&id) {
            return inferred;
        }
        let result = match self.graph.term(id) {
            Term::Number(_) | Term::Slope(..) => None,
            Term::Symbol(symbol) => (self.symbol)(symbol),
            Term::Interpolate(_, x) => {
                self.of(x);
                None
            }
            Term::Unary(function, x) => {
                let inner = self.of(x);
                self.unary(function, inner)
            }
            Term::Binary(function, a, b) => {
                let (left, right) = (self.of(a), self.of(b));
                self.binary(function, (a, left), (b, right))
            }
        };
        self.dimensions.insert(id, result);
        result
    }

    fn clash(&mut self, message: String) {
        if !self.clashes.contains(&message) {
            self.clashes.push(message);
        }
    }

    fn unary(&mut self, function: Unary, x: Inferred) -> Inferred {
        let name = match function {
            Unary::Negate | Unary::Abs => return x,
            Unary::Sqrt => return x.map(|d| d.power(0.5)),
            Unary::Step | Unary::Sign => return Some(Dimension::NONE),
            Unary::SqrtSlope | Unary::SmoothstepSlope => return None,
            Unary::Exp => "exp",
            Unary::Log => "log",
            Unary::Sin => "sin",
            Unary::Cos => "cos",
            Unary::Tanh => "tanh",
            Unary::Smoothstep => "smoothstep",
        };
        if let Some(dimension) = x.filter(|d| !d.is_none()) {
            self.clash(format!("{name} is taken of something in {dimension}"));
        }
        Some(Dimension::NONE)
    }

    fn binary(&mut self, function: Binary, (a, left): (ExprId, Inferred), (b, right): (ExprId, Inferred)) -> Inferred {
        match function {
            Binary::Multiply => Some(left?.times(right?)),
            Binary::Divide => Some(left?.over(right?)),
            Binary::Add | Binary::Subtract | Binary::Minimum | Binary::Maximum | Binary::AtLeast => {
                if let (Some(x), Some(y)) = (left, right)
                    && x != y
                {
                    let verb = match function {
                        Binary::Add => "added to",
                        Binary::Subtract => "subtracted from",
                        _ => "compared with",
                    };
                    let (first, second) = if function == Binary::Subtract { (y, x) } else { (x, y) };
                    self.clash(format!("something in {first} is {verb} something in {second}"));
                }
                if function == Binary::AtLeast {
                    return Some(Dimension::NONE);
                }
                // A number takes the unit of what it is added to.
                let number = |id: ExprId| self.graph.constant(id).is_some();
                match (left, right) {
                    (Some(x), Some(_)) => Some(x),
                    (Some(x), None) if number(b) => Some(x),
                    (None, Some(y)) if number(a) => Some(y),
                    _ => None,
                }
            }
            Binary::Power => {
                if let Some(dimension) = right.filter(|d| !d.is_none()) {
                    self.clash(format!("an exponent is in {dimension}"));
                }
                match (left, self.graph.constant(b)) {
                    (Some(x), Some(exponent)) => Some(x.power(exponent)),
                    (Some(x), None) if x.is_none() => Some(x),
                    _ => None,
                }
            }
            Binary::PowerSlope => None,
        }
    }
}
