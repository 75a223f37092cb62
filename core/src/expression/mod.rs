//! Expressions: parse, check units, differentiate, compile.

pub mod dimension;
pub mod graph;
mod hasher;
pub mod infer;
pub mod parse;
pub mod program;
pub mod schedule;
pub mod scope;
pub mod unit;

pub use dimension::Dimension;
pub use graph::{Binary, Dependence, ExprId, Graph, Symbol, Table, Term, Unary};
pub use parse::{Fault, ParseError, parse};
pub use program::{Program, Register, Segment};
pub use scope::{Names, Scope};
pub use unit::{Unit, UnitError};
