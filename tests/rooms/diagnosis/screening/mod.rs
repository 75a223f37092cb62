mod family;
pub mod fixture;
mod score;
