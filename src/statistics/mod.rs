//! Moments, quantiles, intervals, histograms, ranks.

pub mod beta;
pub mod chain_diagnostics;
