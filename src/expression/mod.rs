//! Expressions: parse, check units, differentiate, compile.

pub mod dimension;
pub mod graph;
pub mod program;
pub mod unit;

pub use dimension::Dimension;
pub use graph::{Binary, Dependence, ExprId, Graph, Symbol, Table, Term, Unary};
pub use program::{Lanes, Program, Register};
pub use unit::{Unit, UnitError};
