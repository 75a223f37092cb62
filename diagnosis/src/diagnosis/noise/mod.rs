//! Noise that is not wholly known.
//!
//! `estimate`: noise that is estimated, so that missing physics is not taken for it, by the `restricted_likelihood`. `overstated`: noise that
//! is stated too large. `like_sensors`: that of like sensors over few phases. `model_error`: what the model owes beside the noise.

pub mod estimate;
pub mod like_sensors;
pub mod model_error;
pub(crate) mod overstated;
pub mod restricted_likelihood;
