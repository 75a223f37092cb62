//! Moments, quantiles, intervals, histograms, regression, autocorrelation, goodness of fit.

pub mod autocorrelation;
pub mod histogram;
pub mod interval;
pub mod kolmogorov;
pub mod moments;
pub mod quantile;
pub mod regression;

pub use interval::Interval;
pub use moments::Moments;
