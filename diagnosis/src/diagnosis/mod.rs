//! What physics a model is missing: the model against measurements, with every effect of a catalogue at every place.
//!
//! In the order of a diagnosis: `problem` (what is diagnosed), `reference_temperature` (about which it worked), `thinned` (the same on fewer rows), `hypothesis` (its model with a set of effects), `linearisation`, `screening`, `fits`, `noise`, `heat` (what is missing
//! whatever its name, and what heat a fitted effect carries), `odds`, `verdict`, `output`. `engine` is the course, `search` which sets are fitted next, `left_out` which readings are faults, `channel` what one channel shows of that and `together` what several do, `misspecified` what changes where the model is a little wrong everywhere, `story` how effects are added there, `blocks` what stretches of the data say of them. docs/diagnosis-method.md says what is computed, and after whom.

pub mod blocks;
pub mod channel;
pub mod engine;
pub mod error;
pub mod fits;
pub mod heat;
pub mod hypothesis;
pub mod left_out;
pub mod linearisation;
pub mod memory;
mod misspecified;
pub mod noise;
pub mod odds;
pub mod output;
pub mod places;
pub mod problem;
mod query;
mod reference_temperature;
pub mod screening;
pub mod search;
mod settings;
pub mod story;
pub mod thinned;
pub mod together;
pub mod verdict;

pub use crate::inference::null_maximum::Sampling;
pub use engine::{Diagnosis, FitRequest, State};
pub use error::{FitError, Unfitted};
pub use fits::evidence::{Amplitude, Evidence};
pub use fits::refit::Refit;
pub use hypothesis::Hypothesis;
pub use linearisation::linear::{Direction, Linear};
pub use odds::narrow_prior::{PRIOR_OF, wider};
pub use output::{Output, RISES, Verdict};
pub use problem::Problem;
pub use reference_temperature::working_temperatures_k;
pub use screening::family::{Extras, Family, FamilyWise, Member, MemberKind};
pub use screening::score::{Prepared, Score};
pub use settings::Settings;
