//! `bmv run`.

use super::Context;
use super::execute::execute;
use super::options::{PathsArgument, RunOptions};
use super::status::{Failure, Status};

/// Arguments of `bmv run`.
#[derive(Debug, clap::Args)]
pub(super) struct Run {
    #[command(flatten)]
    paths: PathsArgument,
    /// Only jobs of this kind, and what they build upon; may be given more than once
    #[arg(long = "job", value_name = "KIND")]
    kinds: Vec<String>,
    #[command(flatten)]
    options: RunOptions,
}

impl Run {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let wanted = |kind: &str, _: &str| self.kinds.is_empty() || self.kinds.iter().any(|wanted| wanted == kind);
        let executed = execute(&self.paths.paths, &self.options, context, wanted)?;
        if executed.passes.iter().all(|pass| pass.jobs.is_empty()) && !self.kinds.is_empty() {
            return Err(Failure::input(format!("no job of kind `{}`", self.kinds.join("`, `"))));
        }
        Ok(executed.status())
    }
}
