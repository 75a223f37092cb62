//! Statistical behaviour over many seeds.

mod estimators;
mod models;
mod samplers;
