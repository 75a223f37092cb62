//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! `problem`: what is diagnosed. `hypothesis`: the model with a set of effects added. `linear`, `signature`: the whitened
//! problem at a fit and the directions in which effects would move it. `score`, `pairs`, `family`, `detectable`: what
//! stands out, and how surely (`bounded`, `null_maximum`: what these rest on). `evidence`: of linear models in closed form. `noise`: noise that is not wholly known. `refit`, `gaps`, `width`, `weigh`: fits, places of thresholds, evidence, probabilities.
//! `heat`, `carried`, `held_out`, `still`, `trend`, `separate`: what is missing whatever its name, what heat a fitted effect carries, what the held-out rows say, which channels stand still, which inputs follow time, which test would part
//! rivals. `prior_of`: priors that may be too narrow. `hints`, `overstated`: what to check first, in the model and its noise. `engine`, `search`, `conclude`, `words`: the course, the sets that are fitted, the verdict, the sentences. `output`: the result.

pub mod bounded;
mod carried;
mod conclude;
pub mod detectable;
mod engine;
pub mod evidence;
mod exchange;
pub mod family;
#[cfg(test)]
mod family_tests;
#[cfg(test)]
mod fixture;
mod gaps;
mod heat;
mod held_out;
mod hints;
pub mod hypothesis;
pub mod laboratory;
pub mod levels;
mod linear;
mod medium;
mod noise;
pub mod null_maximum;
pub mod output;
mod overstated;
pub mod pairs;
mod prior_of;
pub mod problem;
mod products;
pub mod refit;
pub mod score;
#[cfg(test)]
mod score_tests;
mod screen;
mod search;
mod separate;
mod settings;
mod several;
pub mod signature;
mod still;
mod taken;
mod trend;
mod weigh;
mod width;
mod words;

pub use engine::{Diagnosis, Order, State};
pub use evidence::{Amplitude, Evidence};
pub use family::{Extras, Family, FamilyWise, Member, MemberKind};
pub use hypothesis::{Hypothesis, HypothesisError};
pub use linear::{Direction, Linear};
pub use null_maximum::Sampling;
pub use output::{Output, RISES, Verdict};
pub use prior_of::{PRIOR_OF, wider};
pub use problem::Problem;
pub use refit::Refit;
pub use score::{Prepared, Score};
pub use settings::Settings;
