//! Tests of the crate in one binary, by the tool that wrote the models.
#![allow(clippy::unwrap_used)]

mod esatan;
mod sinda;
mod xija;
