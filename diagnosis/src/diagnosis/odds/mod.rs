//! Probabilities of sets of effects.
//!
//! `prior_odds`: of effects beforehand. `posterior_odds`: of the sets that were fitted. `prior_scale`: how wide the priors of amplitudes are. `medium`: effects that need a gas.
//! `logged_heat`: logged heat that the model does not use.
//! `narrow_prior`: priors of parameters that may be too narrow. `sampling`: how far chance decides between sets that are both a little wrong.

pub(crate) mod logged_heat;
pub mod medium;
pub mod narrow_prior;
pub mod posterior_odds;
pub mod prior_odds;
pub mod prior_scale;
pub mod sampling;
