//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! `problem`: what is diagnosed. `hypothesis`: the model with a set of effects added. `linear`: the whitened problem at a
//! fit and the directions in which effects would move it. `signature`: both of them from a problem.

pub mod hypothesis;
pub mod linear;
pub mod problem;
pub mod signature;

pub use hypothesis::{Hypothesis, HypothesisError};
pub use linear::{Direction, Linear};
pub use problem::Problem;
pub use signature::{SignatureError, Unseen, directions, for_each_direction, linearise};
