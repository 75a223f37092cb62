//! Priors, measurements, likelihood, point estimates, samplers, evidence, predictive checks.

pub mod measurement;
pub mod prediction;
