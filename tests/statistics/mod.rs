//! Statistical behaviour over many seeds.

mod calibration;
mod estimators;
mod evidence;
pub mod models;
pub mod samplers;
