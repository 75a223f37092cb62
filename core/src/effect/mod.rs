//! Physical effects that models miss, as data: the catalogue, where an effect applies, and applying it to a model or
//! a sensor.

pub mod apply;
pub mod candidate;
pub mod catalogue;
pub mod checked;
pub mod form;
pub mod law;
pub mod parameter;
pub mod place;
mod thermometers;

pub use apply::{Applied, ApplyError, Instance, SensorChange, apply};
pub use candidate::{Candidate, Chosen, GroupPlace, Limits, candidates, candidates_at, candidates_within};
pub use catalogue::Catalogue;
pub use checked::Effect;
pub use parameter::EffectParameter;
pub use place::{Bound, PlaceKind, SensorPlace, Site};
pub use thermometers::thermometers;
