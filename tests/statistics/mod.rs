//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod estimators;
mod evidence;
mod hand_on;
pub mod models;
pub mod samplers;
