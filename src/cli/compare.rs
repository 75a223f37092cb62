//! `bmv compare`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::execute::{prepare, run};
use super::options::RunOptions;
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch::{self, Loaded};
use crate::job::compare::Kind;
use crate::report::section::{READINGS, TUNED, results};
use crate::report::terminal;
use crate::report::view::untuned;

/// Arguments of `bmv compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "With --json one document is printed: of several jobs of kind `compare` that of the first in \
                        the order of the file; `bmv show PASS JOB --json` prints another. \
                        A sensor that occurs in several measurements has its statistics over all of them under its \
                        name in `sensors`, and those of each measurement in `measurements`.\n\n\
                        Examples:\n  \
                        bmv compare my-study/pass-1.json\n  \
                        bmv compare my-study/pass-1.json --tuned")]
pub(super) struct Compare {
    /// Pass file
    pass: PathBuf,
    /// Whether each reading stands beside its prediction [default: all with --json, none without]
    #[arg(long, value_name = "WHICH")]
    rows: Option<Rows>,
    /// Run the calibrations that have no result in the cache, and show the tuned state too
    #[arg(long)]
    tuned: bool,
    /// Print one JSON document in SI units
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
        select::one_pass(&self.pass)?;
        let loaded = batch::load(std::slice::from_ref(&self.pass), &context.reading)?;
        let mut prepared = prepare(loaded, Loaded::default(), context, |_, kind, _| kind == "compare")?;
        let mut delivered = Vec::new();
        if !self.tuned {
            let cache = self.options.cache.cache(prepared.passes());
            (prepared, delivered) = prepared.deliver(&cache)?;
        }
        let executed = run(prepared, &self.options, context)?;
        for pass in &executed.passes {
            if !pass.pass.jobs.iter().any(|job| job.spec.kind() == "compare") {
                return Err(Failure::input(format!("`{}` has no job of kind `compare`", escaped(&pass.shown))));
            }
            let mut report = batch::view(pass, &executed)?;
            if self.json {
                if let Some(job) = report.results.iter().find(|job| job.output_of::<Kind>().is_some()) {
                    print_json(&batch::document(job, self.rows != Some(Rows::None))?)?;
                }
                continue;
            }
            let readings = (self.rows == Some(Rows::All)).then(|| READINGS(&report)).flatten();
            batch::without_rows(&mut report);
            let sections: Vec<_> =
                results().chain([TUNED]).filter_map(|build| build(&report)).chain(readings).collect();
            print(&terminal::render(&sections, context.layout))?;
        }
        let shown = escaped(&self.pass.display().to_string());
        let has_adopted = executed.passes.iter().any(|pass| !pass.pass.adopted.is_empty());
        for (job, calibration) in delivered {
            let state = untuned(has_adopted);
            let (job, calibration) = (escaped(&job), escaped(&calibration));
            tell(&format!(
                "`{job}` is of the model {state}: calibration `{calibration}` has no result in the cache; with the \
                 tuned state: bmv compare {shown} --tuned"
            ));
        }
        let diagnoses = |pass: &batch::LoadedPass| pass.pass.jobs.iter().any(|job| job.spec.kind() == "diagnose");
        if !self.json && executed.passes.iter().any(diagnoses) {
            tell(&format!("what would explain the rest: bmv diagnose {shown}"));
        }
        Ok(Status::of_wanted(&executed))
    }
}
