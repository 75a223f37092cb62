//! Numerics against analytic results, published values and golden numbers.

mod build;
mod comparison;
mod derivatives;
mod design;
mod effects;
mod elements;
mod flux;
mod likelihood;
mod monitor_campaign;
pub mod network8_data;
mod orbit;
mod radiator;
mod radiator_campaign;
mod solar_monitor;
mod steady;
mod transient;
