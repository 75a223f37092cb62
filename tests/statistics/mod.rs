//! Statistical behaviour over many seeds.

mod models;
mod samplers;
