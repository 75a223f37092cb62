//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! `problem`: what is diagnosed. `hypothesis`: the model with a set of effects added. `linear`: the whitened problem at a
//! fit and the directions in which effects would move it.

pub mod hypothesis;
pub mod laboratory;
pub mod linear;
pub mod problem;

pub use hypothesis::{Hypothesis, HypothesisError};
pub use linear::{Direction, Linear};
pub use problem::Problem;
