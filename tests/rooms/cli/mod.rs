//! Tests of `src/cli/mod.rs`.

mod diagnose;
mod output;
mod serve_model;

use clap::CommandFactory;

#[test]
fn the_arguments_are_consistent() {
    bmv::cli::Program::command().debug_assert();
}
