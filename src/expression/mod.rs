//! Expressions: parse, check units, differentiate, compile.

pub mod graph;
pub mod program;

pub use graph::{Binary, Dependence, ExprId, Graph, Symbol, Table, Term, Unary};
pub use program::{Lanes, Program, Register, Segment};
