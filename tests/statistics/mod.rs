//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod discrepancy;
mod estimators;
mod evidence;
mod flight_coverage;
pub mod hand_on;
mod job_calibration;
mod laboratory;
pub mod models;
mod monte_carlo;
mod predictive_scores;
pub mod samplers;
