//! Probabilities of sets of effects.
//!
//! `posterior_odds`: of the sets that were fitted. `prior_scale`: how wide the priors of amplitudes are. `medium`: effects that need a gas.
//! `prior_of`: priors of parameters that may be too narrow.

pub(crate) mod medium;
pub(crate) mod posterior_odds;
pub(crate) mod prior_of;
pub(crate) mod prior_scale;
