//! Named, indexed random streams, distributions by their quantiles, Latin hypercube and scrambled Sobol points.

pub mod distribution;

pub use distribution::Distribution;
