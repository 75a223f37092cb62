//! Noise that is not wholly known, and channels that are not to be believed.
//!
//! `estimate`: noise that is estimated, so that missing physics is not taken for it, by the `restricted_likelihood`. `overstated`: noise that
//! is stated too large. `still`: channels that stand still while the model moves.

pub(crate) mod estimate;
pub(crate) mod overstated;
pub(crate) mod restricted_likelihood;
pub(crate) mod still;
