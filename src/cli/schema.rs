//! `bmv schema`.

use clap::ValueEnum;

use super::output::print_json;
use super::status::{Failure, Status};
use super::studies;

/// Arguments of `bmv schema`.
#[derive(Debug, clap::Args)]
pub(super) struct Schema {
    /// Which format
    format: Format,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// model.json
    Model,
    /// pass-N.json
    Pass,
    /// An effect's file
    Effect,
    /// results.json
    Results,
}

impl Schema {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let value = self.format.to_possible_value();
        let name = value.as_ref().map_or("", |value| value.get_name());
        let schema = studies::schema(name).ok_or_else(|| Failure::input(format!("there is no schema of `{name}`")))?;
        print_json(&schema)?;
        Ok(Status::Done)
    }
}
