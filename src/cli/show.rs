//! `bmv show`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::execute::{prepare, run};
use super::options::{RequireOption, RunOptions};
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch::{self, Document, Executed, Loaded, NotThere};
use crate::report::PassReport;
use crate::report::section::{CALIBRATION, SUMMARY, results};
use crate::report::terminal;
use crate::runner::cluster::overview::Overview;

/// Arguments of `bmv show`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Nothing is run unless --run asks for it: what is shown comes from the cache, as `bmv run` left it. \
                        Where a job has no result there, that is said and the exit status is 2.\n\n\
                        Examples:\n  \
                        bmv show my-study/pass-1.json\n  \
                        bmv show my-study/pass-1.json prior --json"
)]
pub(super) struct Show {
    /// Pass file
    pass: PathBuf,
    /// Name of a job [default: all, with the summary]
    job: Option<String>,
    /// Run first what has no result in the cache
    #[arg(long)]
    run: bool,
    /// Print one JSON document in SI units; of all jobs, by name
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    require: RequireOption,
    #[command(flatten)]
    options: RunOptions,
}

impl Show {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        select::one_pass(&self.pass)?;
        let loaded = batch::load(std::slice::from_ref(&self.pass), &context.reading)?;
        if let Some(job) = &self.job {
            loaded.passes.iter().try_for_each(|pass| select::has_job(pass, job))?;
        }
        let wanted = |name: &str| self.job.as_ref().is_none_or(|wanted| wanted == name);
        let mut prepared = prepare(loaded, Loaded::default(), context, |_, _, name| wanted(name))?;
        let may_run = self.run || self.options.is_forced();
        let cache = self.options.cache.cache(prepared.passes());
        let not_there = if may_run { Vec::new() } else { prepared.leave_out_missing(&cache) };
        let executed = run(prepared, &self.options, context)?;
        if self.json {
            self.print_documents(&executed)?;
        }
        for pass in executed.passes.iter().filter(|_| !self.json) {
            let mut report = batch::view(pass, &executed)?;
            batch::without_rows(&mut report);
            let summary = self.job.is_none().then_some(SUMMARY).filter(|_| !report.results.is_empty());
            let sections = summary.into_iter().chain(results()).chain([CALIBRATION]);
            let sections: Vec<_> = sections.filter_map(|build| build(&report)).collect();
            print(&terminal::render(&sections, context.layout))?;
            if let Some(surrogate) = pass.pass.surrogate.as_ref().filter(|_| self.job.is_some()) {
                // With all jobs the summary says so.
                let (model, shown) = (escaped(&surrogate.truth.description), escaped(&pass.shown));
                tell(&format!("results rest on a surrogate of {model}; how good it is: bmv show {shown} surrogate"));
            }
            if !report.results.is_empty() {
                tell(&format!("figures and all numbers: bmv report {}", escaped(&pass.shown)));
            }
        }
        tell_not_there(&not_there);
        let status = Status::of_wanted(&executed);
        if status == Status::Done && !not_there.is_empty() {
            return Ok(Status::WrongInput);
        }
        self.require.judge(&executed, status)
    }

    /// Prints what was found for other programs.
    fn print_documents(&self, executed: &Executed) -> Result<(), Failure> {
        let reports: Vec<PassReport<'_>> =
            executed.passes.iter().map(|pass| batch::view(pass, executed)).collect::<Result<_, _>>()?;
        let mut documents: BTreeMap<&str, Document<'_>> = BTreeMap::new();
        for entry in reports.iter().flat_map(|report| &report.results) {
            documents.insert(&entry.name, batch::document(entry, true)?);
        }
        match self.job.as_ref().map(|job| documents.get(job.as_str())) {
            None => print_json(&documents)?,
            Some(Some(document)) => print_json(document)?,
            Some(None) => {}
        }
        Ok(())
    }
}

/// Tells which results are not in the cache, and the commands that make them.
pub(super) fn tell_not_there(not_there: &[NotThere]) {
    let mut passes: Vec<&str> = not_there.iter().map(|missing_result| missing_result.pass.as_str()).collect();
    passes.dedup();
    for shown in passes {
        let names: Vec<String> = not_there
            .iter()
            .filter(|missing_result| missing_result.pass == shown)
            .map(|missing_result| format!("`{}`", escaped(&missing_result.job)))
            .collect();
        let shown = escaped(shown);
        for missing_result in not_there.iter().filter(|missing_result| missing_result.pass == shown) {
            if let Some(Overview { there, all, run, .. }) = &missing_result.on_cluster {
                let job = escaped(&missing_result.job);
                tell(&format!("{shown}: `{job}`: {there} of {all} blocks; run {} on a cluster", run.short()));
                for line in &missing_result.so_far {
                    tell(&format!("{shown}: `{job}`: {}", escaped(line)));
                }
            }
        }
        let (have, them) = if names.len() == 1 { ("has", "it") } else { ("have", "them") };
        tell(&format!(
            "{shown}: {} {have} no result in the cache; `bmv run {shown}` makes {them}, and so does --run here",
            names.join(", ")
        ));
    }
}
