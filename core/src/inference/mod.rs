//! Inference: `target` (what a posterior is), `prior` (densities and their coordinates), `likelihood` (of measurements, given
//! parameters), `posterior` (both together, unconstrained), `sampler` (chains, importance, tempering), `estimate` (point
//! estimates, evidence, moments between bounds, identifiability), `information` (what a measurement would tell).

pub mod estimate;
pub mod information;
pub mod likelihood;
pub mod posterior;
pub mod prior;
pub mod sampler;
pub mod target;
