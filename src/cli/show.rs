//! `bmv show`.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::Context;
use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, outline, print, print_json};
use super::status::{Failure, Status};

/// Arguments of `bmv show`.
#[derive(Debug, clap::Args)]
pub(super) struct Show {
    /// Pass file
    pass: PathBuf,
    /// Name of a job [default: all]
    job: Option<String>,
    /// Print the result as it is stored; of all jobs, by name
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl Show {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let wanted = |_: &str, name: &str| self.job.as_ref().is_none_or(|wanted| wanted == name);
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, wanted)?;
        if let Some(job) = self.job.as_ref().filter(|_| executed.passes.iter().all(|pass| pass.jobs.is_empty())) {
            return Err(Failure::input(format!("`{}` has no job `{}`", self.pass.display(), escaped(job))));
        }
        let mut results = Map::new();
        for (position, finished) in executed.passes.iter().flat_map(|pass| executed.results(pass)) {
            let node = &executed.plan.nodes()[position];
            let value = &finished.stored.value;
            if !self.json {
                let heading = format!("{} ({}, key {})", escaped(&node.name), node.task.kind(), finished.key.short());
                print(&format!("{heading}\n{}\n", outline(value)))?;
            } else if self.job.is_some() {
                print_json(value.as_ref())?;
            } else {
                results.insert(node.name.clone(), (**value).clone());
            }
        }
        if self.json && self.job.is_none() {
            print_json(&Value::Object(results))?;
        }
        Ok(executed.status())
    }
}
