//! `bmv history`.

use std::path::PathBuf;

use super::Context;
use super::execute::execute_loaded;
use super::options::RunOptions;
use super::output::{print, print_json, shown, tell};
use super::status::{Failure, Status};
use crate::batch::{self, Loaded, is_judge};
use crate::report::section::{error_by_pass, missing_jobs};
use crate::report::terminal;

/// Arguments of `bmv history`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Each pass is judged by its first job of kind `compare` that shows a tuned state, else by its \
                        first. Where a pass has no calibration, its tuned values are null.\n\n\
                        Examples:\n  \
                        bmv history my-study\n  \
                        bmv history my-study --json")]
pub(super) struct HistoryVerb {
    /// Study folder; of a pass file, the pass with its parents
    study: PathBuf,
    /// Print one JSON document in SI units
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

impl HistoryVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let loaded = batch::load(std::slice::from_ref(&self.study), &context.reading)?;
        let mut folders: Vec<&PathBuf> = loaded.passes.iter().map(|pass| &pass.study).collect();
        folders.dedup();
        if folders.len() > 1 {
            let names: Vec<String> = folders.iter().map(|folder| shown(folder)).collect();
            let message = format!("`{}` holds several studies; name one: {}", shown(&self.study), names.join(", "));
            return Err(Failure::input(message));
        }
        let is_folder = self.study.is_dir();
        let parents = if is_folder { Loaded::default() } else { batch::parents(&loaded.passes, &context.reading) };
        let executed = execute_loaded(loaded, parents, &self.options, context, |pass, _, name| is_judge(pass, name))?;
        let passes: Vec<_> = executed.parents.iter().chain(&executed.passes).collect();
        let history = batch::history(&passes, &executed)?;
        if self.json {
            print_json(&history)?;
        } else if let Some(section) = error_by_pass(&history) {
            print(&terminal::render(&[section], context.layout))?;
            let study = shown(&self.study);
            tell(&format!("figure and all numbers: bmv report {study}, bmv history {study} --json"));
        } else if Status::of_wanted(&executed) == Status::Done {
            let study = shown(&self.study);
            let missing = missing_jobs(&history);
            let reasons: Vec<String> = missing.iter().map(|text| format!("\n{}", terminal::sentence(text))).collect();
            return Err(Failure::input(format!(
                "no pass of `{study}` is compared with measurements{}",
                reasons.concat()
            )));
        }
        Ok(Status::of_wanted(&executed))
    }
}
