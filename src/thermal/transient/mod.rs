//! Temperatures over time: stiff integration with error control, events, outputs and derivatives.

pub mod inputs;

pub use inputs::{InputColumn, InputTable};
