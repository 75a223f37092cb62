//! `bmv compare`.

use std::path::PathBuf;

use clap::ValueEnum;
use serde_json::{Map, Value};

use super::Context;
use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, outline, print, print_json};
use super::status::{Failure, Status};

/// Arguments of `bmv compare`.
#[derive(Debug, clap::Args)]
pub(super) struct Compare {
    /// Pass file
    pass: PathBuf,
    /// Whether each reading is printed beside its prediction
    #[arg(long, default_value = "all")]
    rows: Rows,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Rows {
    /// Every reading
    All,
    /// Statistics alone
    None,
}

impl Compare {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, |kind, _| kind == "compare")?;
        let status = executed.status();
        let mut results = Map::new();
        for (position, finished) in executed.passes.iter().flat_map(|pass| executed.results(pass)) {
            let mut value = (*finished.stored.value).clone();
            if let Some(fields) = value.as_object_mut().filter(|_| self.rows == Rows::None) {
                fields.remove("rows");
            }
            results.insert(executed.plan.nodes()[position].name.clone(), value);
        }
        if results.is_empty() && status == Status::Done {
            return Err(Failure::input(format!("`{}` has no job of kind `compare`", self.pass.display())));
        }
        if self.json {
            print_json(&Value::Object(results))?;
        } else {
            for (name, value) in &results {
                print(&format!("{}\n{}\n", escaped(name), outline(value)))?;
            }
        }
        Ok(status)
    }
}
