//! All tests of the crate `bmv` in one binary: by area, and in `rooms` those of one source file each.
#![allow(missing_docs, clippy::unwrap_used)]

mod cli;
mod diagnostics;
mod house;
mod reference;
mod reports;
mod reproducibility;
mod rooms;
mod serial;
mod statistics;
mod verification;
