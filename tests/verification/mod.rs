//! Numerics against analytic results, published values and golden numbers.

mod bent_diagnosis;
pub mod build;
mod comparison;
mod derivatives;
mod design;
mod effects;
mod elements;
mod first_suspects;
mod flux;
mod goal;
mod hidden_effect;
mod likelihood;
mod linear_diagnosis;
mod monitor_calibration;
mod monitor_campaign;
pub mod network8_data;
mod orbit;
pub mod radiator;
mod radiator_campaign;
pub mod sensitivity;
mod signature;
mod solar_monitor;
mod solar_monitor_flight;
mod steady;
mod threshold_diagnosis;
mod transient;
