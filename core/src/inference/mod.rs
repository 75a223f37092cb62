//! Inference: `target` (what a posterior is), `prior` (densities and their coordinates), `likelihood` (of measurements, given
//! parameters), `posterior` (both together, unconstrained), `sampler` (chains, importance, tempering), `estimate` (point
//! estimates, evidence, moments between bounds, identifiability), `information` (what a measurement would tell),
//! `gaussian_process` (regression of what a model leaves unexplained), `joint_discrepancy` (that and the parameters together),
//! `null_maximum` (the best of many dependent tests where nothing is to be found),
//! `surrogate` (a process in the place of a model that takes long to answer).

pub mod estimate;
pub mod gaussian_process;
pub mod information;
pub mod joint_discrepancy;
pub mod likelihood;
pub mod null_maximum;
pub mod posterior;
pub mod prior;
pub mod sampler;
pub mod surrogate;
pub mod target;
