//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! `problem`: what is diagnosed. `hypothesis`: the model with a set of effects added. `linear`, `signature`: the whitened
//! problem at a fit and the directions in which effects would move it. `score`, `pairs`, `family`, `detectable`: what
//! stands out, and how surely. `noise`: noise that is not wholly known. `refit`, `weigh`: fits, evidence, probabilities.
//! `heat`, `held_out`, `separate`: what is missing whatever its name, what the held-out rows say, which test would part
//! rivals. `engine`, `conclude`, `words`: the course, the verdict, the sentences. `output`: the result.

mod conclude;
mod engine;
mod heat;
mod held_out;
pub mod hypothesis;
pub mod linear;
mod noise;
pub mod output;
pub mod problem;
pub mod refit;
mod screen;
mod separate;
mod settings;
mod signature;
mod weigh;
mod words;

pub use engine::{Diagnosis, Order, State};
pub use hypothesis::{Hypothesis, HypothesisError};
pub use linear::{Direction, Linear};
pub use output::{Output, Verdict};
pub use problem::Problem;
pub use refit::Refit;
pub use settings::Settings;
