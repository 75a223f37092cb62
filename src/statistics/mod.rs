//! Moments, quantiles, intervals, histograms, ranks.
