//! `bmv diff`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::Context;
use super::execute::{Executed, execute};
use super::options::RunOptions;
use super::output::{escaped, print, print_json};
use super::status::{Failure, Status};
use crate::runner::{Difference, differences};

/// Arguments of `bmv diff`.
#[derive(Debug, clap::Args)]
pub(super) struct Diff {
    /// Pass file before
    before: PathBuf,
    /// Pass file after
    after: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl Diff {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let run = |path: &PathBuf| execute(std::slice::from_ref(path), &self.options, context, |_, _| true);
        let (before, after) = (run(&self.before)?, run(&self.after)?);
        let names: BTreeSet<String> = names(&before).chain(names(&after)).collect();
        let mut jobs = serde_json::Map::new();
        for name in names {
            let [old, new] = [&before, &after].map(|run| sides(run, &name));
            let definition = differences(&old.0, &new.0);
            let result = differences(&old.1, &new.1);
            if !self.json {
                print(&text(&name, &definition, &result))?;
            }
            jobs.insert(name, json!({ "definition": definition, "result": result }));
        }
        if self.json {
            print_json(&json!({ "jobs": jobs }))?;
        }
        let statuses = [before.status(), after.status()];
        Ok(statuses.into_iter().find(|status| *status != Status::Done).unwrap_or(Status::Done))
    }
}

/// Names of the jobs of the passes that were asked for.
fn names(run: &Executed) -> impl Iterator<Item = String> {
    let ids = run.passes.iter().flat_map(|pass| &pass.jobs);
    ids.filter_map(|id| run.plan.find(id)).map(|position| run.plan.nodes()[position].name.clone())
}

/// Definition and result of a job; null where there is none.
fn sides(run: &Executed, name: &str) -> (Value, Value) {
    let ids = run.passes.iter().flat_map(|pass| &pass.jobs);
    let mut positions = ids.filter_map(|id| Some((id, run.plan.find(id)?)));
    let Some((id, position)) = positions.find(|&(_, position)| run.plan.nodes()[position].name == name) else {
        return (Value::Null, Value::Null);
    };
    let material = serde_json::to_value(run.plan.material(position)).unwrap_or_default();
    let result = run.summary.finished(id).map_or(Value::Null, |finished| (*finished.stored.value).clone());
    (material, result)
}

fn text(name: &str, definition: &[Difference], result: &[Difference]) -> String {
    let mut text = format!("{}\n", escaped(name));
    for (what, found) in [("definition", definition), ("result", result)] {
        match found.len() {
            0 => text.push_str(&format!("  {what}: the same\n")),
            count => text.push_str(&format!("  {what}: {count} differences\n")),
        }
        text.extend(found.iter().map(|difference| format!("    {}\n", escaped(&difference.to_string()))));
    }
    text
}
