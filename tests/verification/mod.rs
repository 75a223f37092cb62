//! Numerics against analytic results, published values and golden numbers.

mod build;
mod derivatives;
mod elements;
mod likelihood;
pub mod network8_data;
mod orbit;
mod steady;
mod transient;
