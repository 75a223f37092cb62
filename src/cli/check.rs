//! `bmv check`.

use serde_json::json;

use super::Context;
use super::execute::execute;
use super::options::{PathsArgument, RunOptions};
use super::output::{escaped, print, print_json, shown, tell};
use super::status::{Failure, Status};
use crate::runner::baseline;

/// Differences that are printed for a job; all are in the JSON document.
const SHOWN: usize = 10;

/// Arguments of `bmv check`. Without `--cache` everything runs anew in a cache of its own.
#[derive(Debug, clap::Args)]
pub(super) struct Check {
    #[command(flatten)]
    paths: PathsArgument,
    /// Archive the results in the studies' `baseline` folders instead of comparing them
    #[arg(long)]
    archive: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl Check {
    pub(super) fn execute(mut self, context: &Context) -> Result<Status, Failure> {
        // Fresh: what an earlier build left in the usual cache proves nothing about this one.
        let fresh = tempfile::tempdir()?;
        self.options.cache.folder.get_or_insert_with(|| fresh.path().to_path_buf());
        let executed = execute(&self.paths.paths, &self.options, context, |_, _| true)?;
        let (mut report, mut text, mut drifted, mut compared) = (Vec::new(), String::new(), 0, 0);
        for pass in &executed.passes {
            for (position, finished) in executed.results(pass) {
                let node = &executed.plan.nodes()[position];
                let inside = baseline::path(&pass.file, &node.name);
                let path = pass.study.join(&inside);
                if self.archive {
                    baseline::archive(&pass.study, &inside, &finished.stored.value)?;
                    text.push_str(&format!("archived {}\n", shown(&path)));
                    continue;
                }
                let Some(differences) = baseline::compare(&path, &finished.stored.value)? else {
                    text.push_str(&format!("{}: nothing archived\n", escaped(&node.id)));
                    continue;
                };
                compared += 1;
                drifted += usize::from(!differences.is_empty());
                let verdict = if differences.is_empty() { "the same" } else { "DRIFTED" };
                text.push_str(&format!("{}: {verdict}\n", escaped(&node.id)));
                for difference in differences.iter().take(SHOWN) {
                    text.push_str(&format!("  {}\n", escaped(&difference.to_string())));
                }
                if differences.len() > SHOWN {
                    text.push_str(&format!("  and {} more\n", differences.len() - SHOWN));
                }
                report.push(json!({ "job": node.id, "differences": differences }));
            }
        }
        if self.json {
            print_json(&json!({ "compared": compared, "drifted": drifted, "jobs": report }))?;
        } else {
            print(&text)?;
        }
        if compared == 0 && !self.archive && Status::of(&executed) == Status::Done {
            // A check that compares nothing must not look as if all were well.
            tell("nothing was compared: no result is archived; `bmv check --archive` does that");
            return Ok(Status::CheckFailed);
        }
        Ok(if drifted > 0 && Status::of(&executed) == Status::Done {
            Status::CheckFailed
        } else {
            Status::of(&executed)
        })
    }
}
