//! Statistical behaviour over many seeds.
