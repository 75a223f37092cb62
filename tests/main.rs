//! All integration tests in one binary.
#![allow(missing_docs)]

mod cli;
mod diagnostics;
mod house;
mod reference;
mod reports;
mod reproducibility;
mod statistics;
mod verification;
