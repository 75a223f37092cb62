//! Probabilities of sets of effects.
//!
//! `prior_odds`: of effects beforehand. `posterior_odds`: of the sets that were fitted. `prior_scale`: how wide the priors of amplitudes are. `medium`: effects that need a gas.
//! `narrow_prior`: priors of parameters that may be too narrow.

pub mod medium;
pub mod narrow_prior;
pub mod posterior_odds;
pub mod prior_odds;
pub mod prior_scale;
