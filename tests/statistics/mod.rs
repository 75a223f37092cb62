//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod estimators;
mod evidence;
mod job_calibration;
pub mod models;
pub mod samplers;
