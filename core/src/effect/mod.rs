//! Physical effects that models miss, as data: the catalogue, where an effect applies, and applying it to a model or
//! a sensor.

pub mod apply;
pub mod candidate;
mod candidates;
pub mod catalogue;
pub mod checked;
pub mod form;
pub mod law;
pub mod parameter;
pub mod place;
mod same_law;
mod thermometers;

pub use apply::{Applied, ApplyError, Instance, SensorChange, apply};
pub use candidate::{Candidate, GroupPlace};
pub use candidates::{Chosen, Limits, candidates, candidates_at, candidates_within};
pub use catalogue::Catalogue;
pub use checked::{Effect, Like, REFERENCE_K, REFERENCE_SYMBOL};
pub use parameter::EffectParameter;
pub use place::{Bound, PlaceKind, SensorPlace, Site};
pub use thermometers::thermometers;
