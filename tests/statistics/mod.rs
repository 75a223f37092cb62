//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod estimators;
mod evidence;
pub mod hand_on;
pub mod models;
pub mod samplers;
