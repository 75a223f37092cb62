//! How much an experiment would tell, before it is done: expected information gain and separation of rivals.
//!
//! Lindley (1956, Ann. Math. Statist. 27, 986): `U = E[ln p(z | theta) - ln p(z)]` over parameters and data, in nats;
//! the expected Kullback-Leibler divergence of posterior and prior of `theta`. Nuisance parameters are integrated out of
//! both densities. Readings are whitened (divided by their noise's standard deviation), so that constants of the
//! densities cancel, and parameters are in coordinates in which the prior is standard normal.

pub mod coordinates;
pub mod estimate;
pub mod linear;
pub mod mixture;
pub mod nested;
pub mod search;
pub mod separation;
