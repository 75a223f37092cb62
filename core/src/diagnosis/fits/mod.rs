//! Sets of effects fitted to the data.
//!
//! `refit`: the fit of a set and its evidence (`evidence`: of linear models in closed form). `threshold_gaps`: where thresholds
//! are tried. `other_noise`: what the evidence is with another noise. `exchange`: exchanged channels. `held_out`: what the held-out rows say.

pub mod evidence;
pub mod exchange;
pub mod held_out;
pub mod other_noise;
pub mod refit;
pub(crate) mod threshold_gaps;
