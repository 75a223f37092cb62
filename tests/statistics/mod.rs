//! Statistical behaviour over many seeds.

mod calibrate;
mod calibration;
mod estimators;
mod evidence;
mod laboratory;
pub mod models;
pub mod samplers;
