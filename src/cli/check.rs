//! `bmv check`.

use serde_json::json;

use super::Context;
use super::execute::execute_loaded;
use super::options::{PathsArgument, RunOptions};
use super::output::{escaped, print, print_json, shown, tell};
use super::status::{Failure, Status};
use crate::batch::regression::{self, JobCheck, NumberCheck, Regression, Verdict};
use crate::batch::{self, Executed, Loaded};
use crate::math::sort::sort_by;
use crate::report::number::significant;
use crate::study::resolve::LARGEST_SEED;

/// Numbers that are printed for a job; all are in the JSON document.
const SHOWN: usize = 10;

/// Arguments of `bmv check`. It runs all jobs, without `--cache` anew in a cache of its own; `bmv plan` checks the files alone.
#[derive(Debug, clap::Args)]
pub(super) struct Check {
    #[command(flatten)]
    paths: PathsArgument,
    /// Run with another seed than the passes state, and compare within Monte Carlo error [default: 1]
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "1",
        value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED),
    )]
    other_seed: Option<u64>,
    /// Write the results down as the baselines, instead of comparing them
    #[arg(long, requires = "because", conflicts_with = "other_seed")]
    renew: bool,
    /// Why the baselines are renewed
    #[arg(long, value_name = "TEXT", requires = "renew", value_parser = reason)]
    because: Option<String>,
    /// When they are renewed, as it is to be written down
    #[arg(long, value_name = "TEXT", requires = "renew", value_parser = reason)]
    date: Option<String>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

/// A reason that says something.
fn reason(text: &str) -> Result<String, String> {
    let text = text.trim();
    if text.is_empty() { Err("it says nothing".to_owned()) } else { Ok(text.to_owned()) }
}

impl Check {
    pub(super) fn execute(mut self, context: &Context) -> Result<Status, Failure> {
        // Fresh: what an earlier build left in the usual cache proves nothing about this one.
        let fresh = tempfile::tempdir()?;
        self.options.cache.folder.get_or_insert_with(|| fresh.path().to_path_buf());
        let loaded = match self.other_seed {
            None => batch::load(&self.paths.paths, &context.reading)?,
            Some(seed) => batch::load_with_seed(&self.paths.paths, seed, &context.reading)?,
        };
        if !self.renew && !regression::has_baselines(&loaded)? {
            // Hours of runs that nothing could be compared with.
            let message = "no pass has a baseline yet, so nothing was run\n  help: `bmv check --renew --because TEXT` runs the \
                           jobs and writes their baselines; `bmv plan` checks the files alone";
            return Err(Failure { status: Status::CheckFailed, ..Failure::input(message) });
        }
        let executed = execute_loaded(loaded, Loaded::default(), &self.options, context, |_, _, _| true)?;
        match &self.because {
            Some(because) if self.renew => self.renew(&executed, because),
            _ => self.compare(&executed),
        }
    }

    fn renew(&self, executed: &Executed, because: &str) -> Result<Status, Failure> {
        let renewed = regression::renew(executed, because, self.date.as_deref())?;
        if self.json {
            print_json(&json!({ "because": because, "jobs": renewed }))?;
        } else {
            let mut text = String::new();
            for job in &renewed {
                let what = if job.is_written { "renewed" } else { "stays" };
                text.push_str(&format!("{what}: {}\n", shown(&job.baseline)));
            }
            print(&text)?;
        }
        Ok(Status::of(executed))
    }

    fn compare(&self, executed: &Executed) -> Result<Status, Failure> {
        let regression = regression::check(executed, self.other_seed)?;
        if self.json {
            print_json(&regression)?;
        } else {
            print(&in_words(&regression))?;
        }
        let status = Status::of(executed);
        if regression.is_empty() && matches!(status, Status::Done | Status::NotConverged) {
            // A check that compares nothing must not look as if all were well.
            tell("nothing was compared");
            return Ok(Status::CheckFailed);
        }
        Ok(match status {
            Status::Done | Status::NotConverged if regression.is_alarm() => Status::CheckFailed,
            status => status,
        })
    }
}

/// The findings, what is wrong last, so that it is what is seen first in a terminal.
fn in_words(regression: &Regression) -> String {
    let mut text = String::new();
    for reason in &regression.skipped {
        text.push_str(&format!("SKIPPED: {}\n", escaped(reason)));
    }
    let (wrong, well): (Vec<&JobCheck>, Vec<&JobCheck>) =
        regression.jobs.iter().partition(|job| job.verdict.is_alarm());
    well.into_iter().chain(wrong).for_each(|job| text.push_str(&of_job(job)));
    for orphan in &regression.orphans {
        text.push_str(&format!("{}: NO JOB has this baseline; remove it\n", shown(orphan)));
    }
    text.push_str(&summary(regression));
    text
}

fn summary(regression: &Regression) -> String {
    let counted = |verdict, words: &str| match regression.count(verdict) {
        0 => None,
        count => Some(format!("{count} {words}")),
    };
    let parts = [
        counted(Verdict::Same, "the same bit for bit"),
        counted(Verdict::Agrees, "agree"),
        counted(Verdict::NotComparable, "without a Monte Carlo error to compare by"),
        counted(Verdict::Drifted, "DRIFTED"),
        counted(Verdict::Differs, "DIFFER"),
        counted(Verdict::Missing, "WITHOUT a baseline"),
        Some(format!("{} skipped", regression.skipped.len())).filter(|_| !regression.skipped.is_empty()),
    ];
    let mut text = format!("{} jobs", regression.jobs.len());
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    text.push_str(&format!(": {}\n", parts.join(", ")));
    if let Some(seed) = regression.other_seed {
        let (count, level) = (regression.comparisons, 100.0 * regression.level);
        text.push_str(&format!("{count} comparisons with seed {seed}; any alarm by chance: {level} % at most\n"));
    }
    if regression.count(Verdict::Missing) > 0 {
        text.push_str("`bmv check --renew --because TEXT` writes the baselines that are not there\n");
    } else if regression.is_alarm() {
        text.push_str("if that is meant: `bmv check --renew --because TEXT`\n");
    }
    text
}

fn of_job(job: &JobCheck) -> String {
    let id = escaped(&job.job);
    let mut text = match job.verdict {
        Verdict::Missing => format!("{id}: NO BASELINE in {}\n", shown(&job.baseline)),
        Verdict::Same => format!("{id}: the same\n"),
        Verdict::Drifted => format!("{id}: DRIFTED\n"),
        Verdict::Agrees => format!("{id}: agrees\n"),
        Verdict::Differs => format!("{id}: DIFFERS\n"),
        Verdict::NotComparable => format!("{id}: nothing to compare with another seed\n"),
    };
    if job.verdict.is_alarm() {
        if let Some(renewed) = &job.renewed {
            text.push_str(&format!("  baseline: {}\n", escaped(renewed)));
        }
        for changed in &job.changed {
            text.push_str(&format!("  changed: {changed}\n"));
        }
    }
    let is_shown = |number: &&NumberCheck| number.differs || job.verdict == Verdict::Drifted;
    let mut shown: Vec<&NumberCheck> = job.numbers.iter().filter(is_shown).collect();
    let size = |number: &NumberCheck| number.standard_errors.map_or(f64::INFINITY, f64::abs);
    sort_by(&mut shown, |a, b| size(b).total_cmp(&size(a)));
    for number in shown.iter().take(SHOWN) {
        text.push_str(&format!("  {}\n", escaped(&moved(number))));
    }
    if shown.len() > SHOWN {
        text.push_str(&format!("  and {} more\n", shown.len() - SHOWN));
    }
    if job.verdict == Verdict::Drifted && shown.is_empty() {
        text.push_str("  no key number moved: something else of the result did\n");
    }
    for number in job.numbers.iter().filter(|number| number.is_of_interest()) {
        if let Some(detectable) = number.detectable {
            let of_value =
                number.detectable_percent.map_or_else(String::new, |p| format!(" ({} %)", significant(p, 2)));
            let line = format!("would see {}{of_value}", with_unit(detectable, 2, &number.unit));
            text.push_str(&format!("  {}: {}\n", escaped(&number.of), escaped(&line)));
        }
    }
    text
}

/// A number with its unit; `1` is none.
fn with_unit(value: f64, digits: usize, unit: &str) -> String {
    let unit = if unit == "1" { "" } else { unit };
    format!("{} {unit}", significant(value, digits)).trim_end().to_owned()
}

/// By how much a number moved.
fn moved(number: &NumberCheck) -> String {
    let name = format!("{}, {}", number.of, number.statistic);
    let (Some(before), Some(after)) = (number.before, number.after) else {
        let (word, value) = if number.before.is_none() { ("new", number.after) } else { ("gone, was", number.before) };
        return format!("{name}: {word} {}", with_unit(value.unwrap_or(f64::NAN), 6, &number.unit));
    };
    let difference = after - before;
    let mut text = format!("{name}: {} -> {}", significant(before, 6), with_unit(after, 6, &number.unit));
    let sign = if difference > 0.0 { "+" } else { "" };
    text.push_str(&format!(": {sign}{}", with_unit(difference, 3, &number.unit)));
    if before != 0.0 {
        text.push_str(&format!(", {sign}{} %", significant(100.0 * difference / before.abs(), 2)));
    }
    if let Some(errors) = number.standard_errors {
        text.push_str(&format!(", {} standard errors", significant(errors.abs(), 2)));
    }
    if let Some(p) = number.p {
        text.push_str(&format!(", p = {}", significant(p, 2)));
    }
    text
}
