//! `bmv show`.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, studies};
use crate::report::section::{RESULTS, SUMMARY};
use crate::report::terminal;

/// Arguments of `bmv show`.
#[derive(Debug, clap::Args)]
pub(super) struct Show {
    /// Pass file
    pass: PathBuf,
    /// Name of a job [default: all, with the summary]
    job: Option<String>,
    /// Print one JSON document in SI units; of all jobs, by name
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl Show {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        studies::one_pass(&self.pass)?;
        let wanted = |_: &str, name: &str| self.job.as_ref().is_none_or(|wanted| wanted == name);
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, wanted)?;
        let mut documents = Map::new();
        for pass in &executed.passes {
            if let Some(job) = &self.job {
                studies::has_job(pass, job)?;
            }
            let mut report = studies::view(pass, &executed)?;
            if self.json {
                for entry in &report.results {
                    documents.insert(entry.name.clone(), studies::document(entry, true)?);
                }
                continue;
            }
            studies::without_rows(&mut report);
            let summary = self.job.is_none().then_some(&SUMMARY);
            let sections: Vec<_> = summary.into_iter().chain(RESULTS).filter_map(|build| build(&report)).collect();
            print(&terminal::render(&sections, context.layout))?;
            if !report.results.is_empty() {
                tell(&format!("figures and all numbers: bmv report {}", escaped(&pass.shown)));
            }
        }
        if self.json {
            match self.job.as_ref().map(|job| documents.remove(job)) {
                None => print_json(&Value::Object(documents))?,
                Some(Some(document)) => print_json(&document)?,
                Some(None) => {}
            }
        }
        Ok(executed.status_of_wanted())
    }
}
