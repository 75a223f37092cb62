//! Numerics against analytic results, published values and golden numbers.

mod build;
mod orbit;
mod steady;
