mod between_values;
mod family;
pub mod fixture;
mod score;
