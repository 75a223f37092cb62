//! `bmv lab`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use super::Context;
use super::options::RunOptions;
use super::output::{escaped, print, print_json, shown, table, tell};
use super::status::{Failure, Status};
use crate::document::{counted, suggest};
use crate::job::lab::{Lab, Output, Spec};
use crate::runner::engine::local;
use crate::runner::{Node, Plan, Progress, Ready, RunnerError, Settings};
use crate::study::Project;
use crate::study::file::{self, Existing};
use crate::twin::{Rate, Score, case, dated, finer, folder, standard};

/// Arguments of `bmv lab`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A size is what the refitted model leaves of readings without noise: root mean square, in standard \
                        deviations of the noise. `separable` are cases that no other effect explains. Without STUDY, \
                        --write draws networks and tests of its own."
)]
pub(super) struct LabVerb {
    /// Pass file, or folder of a study with one pass [default: networks are drawn]
    study: Option<PathBuf>,
    /// Hide this effect, or one at its place by id [default: drawn from the catalogue]
    #[arg(long, value_name = "ID-or-NAME")]
    effect: Option<String>,
    /// Its amplitude in SI units [default: such that 0.5, 1 or 2 standard deviations are left]
    #[arg(long, value_name = "X", allow_negative_numbers = true, requires = "effect")]
    amplitude: Option<f64>,
    /// Number of cases
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    cases: u64,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Write cases over drawn networks as studies into this folder, each with its truth.json
    #[arg(long, value_name = "DIR", conflicts_with_all = ["study", "effect", "amplitude"])]
    write: Option<PathBuf>,
    /// Write cases whose truth is a finer network than the believed one, which is a little wrong everywhere
    #[arg(long, requires = "write")]
    finer: bool,
    /// Write cases in which heat, a conductance or a sensor changes at a date
    #[arg(long, requires = "write", conflicts_with = "finer")]
    dated: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

/// Findings printed of a file.
const MOST_DIAGNOSTICS: usize = 50;

impl LabVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        if let Some(folder) = &self.write {
            return self.write(folder, context);
        }
        if self.amplitude.is_some_and(|amplitude| !amplitude.is_finite() || amplitude == 0.0) {
            return Err(Failure::input("an amplitude is a number other than 0"));
        }
        let spec = Spec { effect: self.effect.clone(), amplitude: self.amplitude, cases: self.cases, seed: self.seed };
        let rendered =
            |wrong: crate::document::Diagnostics| Failure::rendered(wrong.render(context.coloured, MOST_DIAGNOSTICS));
        let mut project = Project::here();
        let (shown_id, lab) = match &self.study {
            Some(study) => {
                let path = super::select::one_pass(study)?;
                let pass = crate::job::load(&path).map_err(rendered)?;
                project = Project::of(&pass.folder);
                if !pass.warnings.is_empty() {
                    tell(&pass.warnings.render(context.coloured, MOST_DIAGNOSTICS));
                }
                if pass.measurements.is_empty() {
                    return Err(Failure::input(format!("`{}` has no measurement to simulate", shown(&path))));
                }
                if let Some(reference) = pass.posterior_priors.first() {
                    return Err(Failure::input(format!(
                        "the laboratory draws truths from distributions, and in `{}` {} has the draws of {} as its prior; \
                         name a pass with the prior that they began with",
                        shown(&path),
                        suggest::listed(reference.draws.names.iter().map(String::as_str), 6),
                        reference.draws.source
                    )));
                }
                let problem = Arc::new(crate::study::problem(&pass));
                let lab = Lab::new(spec, problem).map_err(|error| Failure::input(error.to_string()))?;
                (path.display().to_string(), lab)
            }
            None if self.effect.is_some() => {
                return Err(Failure::input("name the pass or study in which the effect is hidden".to_owned()));
            }
            None => {
                let catalogue = crate::study::effects(None).map_err(rendered)?;
                ("drawn networks".to_owned(), Lab::drawn(spec, Arc::new(catalogue)))
            }
        };
        let id = format!("{shown_id}:lab");
        let task = Box::new(Ready(Arc::new(lab)));
        let plan =
            Plan::new(vec![Node { id: id.clone(), name: "lab".to_owned(), seed: self.seed, from: vec![], task }])?;
        let progress = Progress::on_standard_error();
        let settings = Settings { only: None, ..self.options.settings() };
        let cache = self.options.cache.cache_of(&project);
        let summary = context.interrupts.during(|stop| local::run(&plan, &cache, &settings, stop, &progress))?;
        if summary.is_interrupted() {
            return Ok(Status::Interrupted);
        }
        let Some(finished) = summary.finished(&id) else { return Ok(Status::JobFailed) };
        if self.json {
            print_json(&*finished.stored.value)?;
            return Ok(Status::Done);
        }
        let output = Output::deserialize(&*finished.stored.value)
            .map_err(|error| Failure::job(format!("the laboratory's result: {error}")))?;
        print(&table_of(&output, context.fold))?;
        Ok(Status::Done)
    }

    fn write(&self, folder: &Path, context: &Context) -> Result<Status, Failure> {
        let catalogue = crate::study::effects(None)
            .map_err(|wrong| Failure::rendered(wrong.render(context.coloured, MOST_DIAGNOSTICS)))?;
        let catalogue = Arc::new(catalogue);
        let mut written = Vec::new();
        for number in 0..self.cases {
            let name = format!("case-{}-{number:04}", self.seed);
            let recipe = match (self.finer, self.dated) {
                (true, _) => finer(number),
                (_, true) => dated(number),
                _ => standard(number),
            };
            let case = match case(&catalogue, &recipe, self.seed, number) {
                Ok(case) => case,
                Err(error) => {
                    tell(&format!("{name}: not drawn: {error}"));
                    continue;
                }
            };
            for (file, text) in folder::files(&case) {
                let path = Path::new(&name).join(file);
                file::write(folder, &path, text.as_bytes(), Existing::Replace)
                    .map_err(RunnerError::file("write", folder.join(&path)))?;
            }
            written.push(name);
        }
        if self.json {
            print_json(&serde_json::json!({"folder": folder, "cases": written}))?;
        } else {
            print(&format!("{} in {}\n", counted(written.len(), "case"), escaped(&folder.display().to_string())))?;
        }
        Ok(Status::Done)
    }
}

/// A rate with its interval, in percent.
fn percent(rate: &Rate) -> String {
    match rate.share() {
        Some(share) => {
            format!("{:.0} % of {} ({:.0} to {:.0})", 100.0 * share, rate.of, 100.0 * rate.lower, 100.0 * rate.upper)
        }
        None => "none".to_owned(),
    }
}

fn table_of(output: &Output, fold: Option<usize>) -> String {
    let diagnosed = output.rows.iter().any(|row| row.found.is_some());
    let mut heading = vec!["hidden", "size", "separable"];
    if diagnosed {
        heading.extend(["found", "named", "in a small group"]);
    }
    let mut rows: Vec<Vec<String>> = vec![heading.into_iter().map(str::to_owned).collect()];
    for row in &output.rows {
        let nothing = row.effect == "nothing";
        let mut cells = vec![
            escaped(&row.effect),
            if nothing { String::new() } else { format!("{:.1}", row.size.unwrap_or(row.mean_size)) },
            if nothing { String::new() } else { percent(&row.separable) },
        ];
        if diagnosed {
            let rates = [&row.found, &row.named, &row.grouped];
            let shown = |rate: &Option<Rate>| rate.as_ref().map(percent).unwrap_or_default();
            cells.extend(rates.into_iter().take(if nothing { 1 } else { 3 }).map(shown));
        }
        rows.push(cells);
    }
    let mut text = table(&rows, fold);
    if let Some(score) = &output.score {
        text.push('\n');
        text.push_str(&summary(score, fold));
    }
    for (reason, count) in &output.reasons {
        text.push_str(&format!("{}: {}\n", counted(*count, "case"), escaped(reason)));
    }
    text
}

/// The score in lines.
fn summary(score: &Score, fold: Option<usize>) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut line = |what: String, rate: &Rate| {
        if rate.of > 0 {
            rows.push(vec![what, percent(rate)]);
        }
    };
    line("false alarms, noise as stated".to_owned(), &score.false_alarms_stated_noise);
    line("false alarms, correlated noise".to_owned(), &score.false_alarms_correlated);
    for size in &score.sizes {
        let what = format!("{} hidden of size {}", size.effects, size.size);
        for (which, rates) in [("all", &size.all), ("separable", &size.separable)] {
            line(format!("{what}, {which}: found"), &rates.found);
            line(format!("{what}, {which}: named"), &rates.named);
            line(format!("{what}, {which}: in a small group"), &rates.grouped);
        }
    }
    line("outside the catalogue: said to be unexplained".to_owned(), &score.outside_unexplained);
    line("outside the catalogue: misnamed".to_owned(), &score.outside_misnamed);
    line("amplitude intervals of 95 % that hold the truth".to_owned(), &score.coverage);
    line("answers given 0.9 or more that are right".to_owned(), &score.sure_and_right);
    for bin in &score.reliability {
        line(format!("effects given {:.2} to {:.2} that are true", bin.lower, bin.upper), &bin.true_rate);
    }
    let mut text = table(&rows, fold);
    if let Some(log_score) = score.log_score {
        text.push_str(&format!("mean log probability stated of the truth: {log_score:.2}\n"));
    }
    text
}
