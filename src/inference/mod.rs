//! Priors, measurements, likelihood, point estimates, samplers, evidence, predictive checks.

pub mod adaptation;
pub mod box_probability;
pub mod chains;
pub mod cholesky;
pub mod convergence;
pub mod identifiability;
pub mod importance;
pub mod information;
pub mod lag;
pub mod likelihood;
pub mod measurement;
pub mod metric;
pub mod metropolis;
pub mod natural;
pub mod noise;
pub mod nuts;
pub mod optimise;
pub mod point_estimate;
pub mod posterior;
pub mod prediction;
mod proposal;
pub mod psis;
pub mod smc;
pub mod target;
pub mod transform;
pub mod unknown;
