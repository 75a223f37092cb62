//! Moments, quantiles, intervals, histograms, regression, autocorrelation, goodness of fit,
//! convergence of chains, errors by Monte Carlo, sensitivity, tolerance limits.

pub mod autocorrelation;
pub mod chain_diagnostics;
pub mod clusters;
pub mod elementary_effects;
pub mod given_data;
pub mod histogram;
pub mod interval;
pub mod kolmogorov;
pub mod moments;
pub mod monte_carlo;
pub mod noise;
pub mod poincare;
pub mod quantile;
pub mod regression;
pub mod sobol_indices;
pub mod tolerance;

pub use interval::Interval;
pub use moments::Moments;
