//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! `problem`: what is diagnosed. `hypothesis`: the model with a set of effects added. `linear`: the whitened problem at a
//! fit and the directions in which effects would move it.
//! `score`: what a direction would gain between all bounds (`bounded`), and what the data see of it. `pairs`: the best of all
//! pairs. `family`: whether the best could be chance (`null_maximum`). `detectable`: what would have been seen.
//! `evidence`: of linear models, in closed form.

pub mod bounded;
pub mod detectable;
pub mod evidence;
pub mod family;
#[cfg(test)]
mod family_tests;
#[cfg(test)]
mod fixture;
pub mod hypothesis;
pub mod linear;
pub mod null_maximum;
pub mod pairs;
pub mod problem;
mod products;
pub mod score;
#[cfg(test)]
mod score_tests;
mod several;

pub use evidence::{Amplitude, Evidence};
pub use family::{Extras, Family, FamilyWise, Member, MemberKind};
pub use hypothesis::{Hypothesis, HypothesisError};
pub use linear::{Direction, Linear};
pub use null_maximum::Sampling;
pub use problem::Problem;
pub use score::{Prepared, Score};
