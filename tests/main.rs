//! Tests of the crates `bmv`, `bmv-core` and `bmv-diagnosis` in one binary, but for `allocation`: by area, and in `rooms` those of one source file each.
//! Three tiers: `cargo test` runs those of less than a second or so; the gate also those that are ignored as `thorough`;
//! `just nightly` also those of the modules named `nightly`, which take a minute and more, or measure time.
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
