//! Priors, measurements, likelihood, point estimates, samplers, evidence, predictive checks.

pub mod adaptation;
pub mod chains;
pub mod cholesky;
pub mod measurement;
pub mod metric;
pub mod metropolis;
pub mod nuts;
pub mod posterior;
mod proposal;
pub mod psis;
pub mod smc;
pub mod target;
pub mod transform;
