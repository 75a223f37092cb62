//! Moments, quantiles, intervals, histograms, regression, autocorrelation, goodness of fit,
//! convergence of chains.

pub mod autocorrelation;
pub mod chain_diagnostics;
pub mod clusters;
pub mod histogram;
pub mod interval;
pub mod kolmogorov;
pub mod moments;
pub mod quantile;
pub mod regression;

pub use interval::Interval;
pub use moments::Moments;
