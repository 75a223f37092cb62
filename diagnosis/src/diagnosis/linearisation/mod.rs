//! The whitened problem, linearised at a fit, and the directions in which effects would move it.
//!
//! `signature`: the directions of effects. `between_rows`: coordinates of those of long records. `threshold_levels`: the levels of data between which thresholds lie.
//! `bounded`: what scores rest on.

pub mod between_rows;
pub mod bounded;
pub mod linear;
pub mod signature;
pub mod threshold_levels;
