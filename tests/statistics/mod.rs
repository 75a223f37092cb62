//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod estimators;
mod laboratory;
mod evidence;
pub mod models;
pub mod samplers;
