//! The whitened problem, linearised at a fit, and the directions in which effects would move it.
//!
//! `signature`: the directions of effects. `multi_column`: those of several columns. `scalar_products`, `bounded`: what scores rest
//! on.

pub mod bounded;
pub mod linear;
pub(crate) mod multi_column;
pub(crate) mod scalar_products;
pub mod signature;
