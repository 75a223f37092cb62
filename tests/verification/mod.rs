//! Numerics against analytic results, published values and golden numbers.

mod build;
mod comparison;
mod derivatives;
mod effects;
mod elements;
mod flux;
mod goal;
mod likelihood;
mod monitor_campaign;
pub mod network8_data;
mod orbit;
mod radiator;
pub mod sensitivity;
mod solar_monitor;
mod steady;
mod transient;
