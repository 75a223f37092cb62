mod logged_heat;
mod medium;
mod narrow_prior;
mod posterior_odds;
mod prior_odds;
mod prior_scale;
mod sampling;
