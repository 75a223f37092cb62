//! Sets of effects fitted to the data.
//!
//! `hypothesis`: the model with a set added. `refit`: its fit and evidence (`evidence`: of linear models in closed form). `search`: which
//! sets are fitted next. `threshold_levels`, `threshold_gaps`: where thresholds are tried. `exchange`: exchanged channels.
//! `held_out`: what the held-out rows say.

pub mod evidence;
pub(crate) mod exchange;
pub(crate) mod held_out;
pub mod hypothesis;
pub mod refit;
pub(crate) mod search;
pub(crate) mod threshold_gaps;
pub mod threshold_levels;
