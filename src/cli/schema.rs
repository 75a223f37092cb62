//! `bmv schema`.

use clap::ValueEnum;
use serde_json::Value;

use super::output::print_json;
use super::status::{Failure, Status};
use crate::report;

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
    /// document.json
    Document,
    /// An effect's file
    Effect,
    /// results.json
    Results,
}

impl Schema {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let value = self.format.to_possible_value();
        let name = value.as_ref().map_or("", |value| value.get_name());
        let schema = schema(name).ok_or_else(|| Failure::input(format!("there is no schema of `{name}`")))?;
        print_json(&schema)?;
        Ok(Status::Done)
    }
}

/// JSON Schema of a file format: `model`, `pass`, `document`, `effect`, `results`. Nothing for a name that is none of them.
fn schema(format: &str) -> Option<Value> {
    match format {
        "results" => Some(report::results_schema()),
        _ => crate::study::schema(format, &crate::job::kinds()).ok(),
    }
}
