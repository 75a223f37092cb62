//! Numerics against analytic results, published values and golden numbers.

mod build;
mod comparison;
mod derivatives;
mod effects;
mod elements;
mod flux;
mod hidden_effect;
mod likelihood;
mod monitor_campaign;
pub mod network8_data;
mod orbit;
mod radiator;
mod signature;
mod solar_monitor;
mod steady;
mod transient;
