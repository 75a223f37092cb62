//! Sets of effects fitted to the data.
//!
//! `refit`: the fit of a set and its evidence (`evidence`: of linear models in closed form). `threshold_gaps`: where thresholds
//! are tried. `other_noise`: what the evidence is with another noise. `exchange`: exchanged channels. `held_out`: what the held-out rows say.
//! `held_level`: effects that hold a temperature at which the readings dwell. `controlled_heat`: heats that a control makes. `level_starts`: where the fit of an effect begins that is about a level of a temperature.
//! `effect_heat_flow`: the heat that fitted effects carry. `size`: which effects are larger than plausible. `out_of_range`:
//! values at which an effect is not what it is called.

pub mod controlled_heat;
pub(crate) mod effect_heat_flow;
pub mod evidence;
pub mod exchange;
pub mod held_level;
pub mod held_out;
pub(crate) mod level_starts;
pub mod other_noise;
pub(crate) mod out_of_range;
pub mod refit;
pub mod size;
pub(crate) mod threshold_gaps;
