//! Statistical behaviour over many seeds.

mod estimators;
