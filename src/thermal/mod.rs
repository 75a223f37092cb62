//! The thermal network: model, compiled network, steady and transient solutions, exact derivatives.

pub mod element;
pub mod identity;
pub mod model;

pub use model::{Input, Limits, Model, Node, NodeKind, Parameter, Quantity, QuantityValue};
