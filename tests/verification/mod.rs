//! Numerics against analytic results, published values and golden numbers.

mod build;
mod derivatives;
mod effects;
mod elements;
mod orbit;
mod steady;
mod transient;
