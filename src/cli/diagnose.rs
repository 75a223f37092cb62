//! `bmv diagnose`.

use std::path::PathBuf;

use super::execute::execute;
use super::options::RunOptions;
use super::output::{escaped, print, print_json, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch;
use crate::diagnosis::Output;
use crate::diagnosis::output::EffectResult;
use crate::document::visible::shell_word;
use crate::job::diagnose;
use crate::measurement::Doubt;
use crate::report::section::DIAGNOSIS;
use crate::report::terminal;

/// Arguments of `bmv diagnose`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "With --json one document is printed: of several jobs of kind `diagnose` that of the first, in \
                        the order of the file; `bmv show PASS JOB --json` prints another.\n\n\
                        Examples:\n  \
                        bmv diagnose my-study/pass-1.json\n  \
                        bmv diagnose my-study/pass-1.json --json"
)]
pub(super) struct Diagnose {
    /// Pass file
    pass: PathBuf,
    /// Print one JSON document in SI units
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

/// What to do next: what is doubtful about the data goes first, then what `bmv adopt` (here with its pass) would take.
pub fn next(output: &Output, adopt: &str) -> Option<String> {
    let adoption = adoption(output, adopt);
    if !output.doubts.iter().any(Doubt::is_of_start) {
        return adoption.map(|adoption| format!("next: {adoption}"));
    }
    let check = "next: check the start, then bmv diagnose again";
    // A sensor that is off looks the same as a start that is.
    Some(adoption.map_or_else(|| check.to_owned(), |adoption| format!("{check}; if the start is right, {adoption}")))
}

/// What of the result `bmv adopt` (here with its pass) would take, to follow `next: `.
fn adoption(output: &Output, adopt: &str) -> Option<String> {
    if output.selected.is_empty() {
        return None;
    }
    if output.verdict.names_one_set() {
        return Some(format!("{adopt} (what belongs to the test alone: with --test-only)"));
    }
    // What errors of the model itself explain as well is not proposed, unless there is nothing else.
    let is_strong = |effect: &&EffectResult| !effect.is_weak();
    let selected: Vec<&EffectResult> = output.selected.iter().filter_map(|id| output.effect(id)).collect();
    let strong: Vec<&EffectResult> = selected.iter().copied().filter(is_strong).collect();
    let proposed = if strong.is_empty() { selected } else { strong };
    let words = |effects: &[&EffectResult]| effects.iter().map(|own| shell_word(&own.id)).collect::<Vec<_>>().join(" ");
    let settled = output.settled();
    if settled.is_empty() {
        let ids = words(&proposed);
        if proposed.iter().all(|effect| output.is_settled(effect)) {
            return Some(format!(
                "what is missing is settled, its law is open; adopt the law that you know, as in {adopt} {ids}"
            ));
        }
        return Some(format!("these data leave it open; what you choose is adopted by name, as in {adopt} {ids}"));
    }
    let all: Vec<&EffectResult> = output.selected.iter().filter_map(|id| output.effect(id)).collect();
    let is_settled = |effect: &&&EffectResult| settled.iter().any(|one| one.id == effect.id);
    let settled_ids = words(&settled);
    if proposed.iter().all(|effect| is_settled(&effect)) {
        let rest = if settled.len() < all.len() {
            "; what else was found may be errors of the model: diagnose again then"
        } else {
            ""
        };
        return Some(format!("{adopt} {settled_ids}{rest}"));
    }
    let with = words(&all.iter().filter(|effect| is_settled(effect) || !effect.is_weak()).copied().collect::<Vec<_>>());
    Some(format!("{adopt} {settled_ids}; the rest is left open, and adopted by name with it, as in {adopt} {with}"))
}

impl Diagnose {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        select::one_pass(&self.pass)?;
        let executed = execute(std::slice::from_ref(&self.pass), &self.options, context, |kind, _| kind == "diagnose")?;
        for pass in &executed.passes {
            if !pass.pass.jobs.iter().any(|job| job.spec.kind() == "diagnose") {
                return Err(Failure::input(format!(
                    "`{}` has no job of kind `diagnose`; write \"jobs\": {{\"missing\": {{\"diagnose\": {{}}}}}}",
                    pass.shown
                )));
            }
            let report = batch::view(pass, &executed)?;
            if self.json {
                let diagnosis = report.results.iter().find(|job| job.output_of::<diagnose::Kind>().is_some());
                if let Some(job) = diagnosis {
                    print_json(&batch::document(job, true)?)?;
                }
                continue;
            }
            let sections: Vec<_> = DIAGNOSIS(&report).into_iter().collect();
            print(&terminal::render(&sections, context.layout))?;
            let jobs = report.outputs::<diagnose::Kind>().count();
            for (name, output) in report.outputs::<diagnose::Kind>() {
                let of_job = if jobs > 1 { format!(" --job {}", shell_word(name)) } else { String::new() };
                if let Some(line) = next(output, &format!("bmv adopt {}{of_job}", shell_word(&pass.shown))) {
                    tell(&escaped(&line));
                }
            }
        }
        Ok(Status::of_wanted(&executed))
    }
}
