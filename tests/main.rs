//! All integration tests in one binary.
#![allow(missing_docs, clippy::unwrap_used)]

mod cli;
mod diagnostics;
mod house;
mod reference;
mod reports;
mod reproducibility;
mod serial;
mod statistics;
mod verification;
