//! `bmv diff`.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::execute::{prepare, run};
use super::options::RunOptions;
use super::output::{escaped, print, print_json};
use super::status::{Failure, Status};
use super::{Context, select, show};
use crate::batch::{self, Executed, Loaded, LoadedPass};
use crate::document::counted;
use crate::report::essentials::essentials;
use crate::report::page::{Block, Cell, Column, Section, Table};
use crate::report::{PassReport, terminal};
use crate::runner::{Difference, differences};
use crate::study::project::whole;
use crate::study::{ChangedEntry, changed};

/// Places of a job's identity that are stated where no entry of the files explains them.
const MOST_UNEXPLAINED: usize = 8;
/// Diagnostics printed of the files.
const MOST_DIAGNOSTICS: usize = 20;

/// Arguments of `bmv diff`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "First what the files say differently, entry by entry, then what became of the results. Nothing is run \
                        unless --run asks for it: results come from the cache."
)]
pub(super) struct Diff {
    /// Pass file before
    before: PathBuf,
    /// Pass file after
    after: PathBuf,
    /// Run first what has no result in the cache
    #[arg(long)]
    run: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: RunOptions,
}

/// A job of one of the passes.
struct Side {
    definition: Value,
    result: Value,
}

impl Diff {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let paths = [select::one_pass(&self.before)?, select::one_pass(&self.after)?];
        // Both at once: what they share is found, or run and reported, once.
        let loaded = batch::load(&paths, &context.reading)?;
        let mut prepared = prepare(loaded, Loaded::default(), context, |_, _, _| true)?;
        let not_there = if self.run || self.options.is_forced() {
            Vec::new()
        } else {
            let cache = self.options.cache.cache(prepared.passes());
            prepared.leave_out_missing(&cache)
        };
        let executed = run(prepared, &self.options, context)?;
        let find = |path: &PathBuf| {
            let passes = executed.passes.iter();
            passes.clone().find(|pass| whole(&pass.study.join(&pass.file)) == whole(path))
        };
        let [Some(old), Some(new)] = paths.each_ref().map(find) else {
            return Err(Failure::input("name two pass files"));
        };
        let entries = changed(&old.pass, &new.pass)
            .map_err(|wrong| Failure::rendered(wrong.render(context.coloured, MOST_DIAGNOSTICS)))?;
        let mut names: Vec<&str> = Vec::new();
        for job in old.pass.jobs.iter().chain(&new.pass.jobs) {
            if !names.contains(&job.name.as_str()) {
                names.push(&job.name);
            }
        }
        let compared: Vec<(&str, Vec<Difference>, Vec<Difference>)> = names
            .iter()
            .map(|&name| {
                let [old, new] = [old, new].map(|pass| side(&executed, pass, name));
                let definition = differences(&old.definition, &new.definition);
                (name, definition, differences(&old.result, &new.result))
            })
            .collect();
        if self.json {
            let jobs: serde_json::Map<String, Value> = compared
                .iter()
                .map(|(name, definition, result)| {
                    ((*name).to_owned(), json!({ "definition": definition, "result": result }))
                })
                .collect();
            print_json(&json!({ "files": entries, "jobs": jobs }))?;
        } else {
            let reports = [batch::view(old, &executed)?, batch::view(new, &executed)?];
            let unexplained =
                if entries.is_empty() { compared.iter().flat_map(|one| &one.1).collect() } else { vec![] };
            let sections = [definitions(&entries, &unexplained), results(&names, &reports)];
            print(&terminal::render(&sections, context.layout))?;
        }
        show::tell_not_there(&not_there);
        let status = Status::of(&executed);
        Ok(if status == Status::Done && !not_there.is_empty() { Status::WrongInput } else { status })
    }
}

/// Definition and result of a job; null where there is none.
fn side(run: &Executed, pass: &LoadedPass, name: &str) -> Side {
    let position = run.plan.find(&format!("{}:{name}", pass.shown));
    let Some(position) = position else { return Side { definition: Value::Null, result: Value::Null } };
    let definition = serde_json::to_value(run.plan.material(position)).unwrap_or_default();
    let finished = run.summary.finished(&run.plan.nodes()[position].id);
    Side { definition, result: finished.map_or(Value::Null, |finished| (*finished.stored.value).clone()) }
}

/// What the files say differently.
fn definitions(entries: &[ChangedEntry], unexplained: &[&Difference]) -> Section {
    let or_none = |value: &Option<String>, none: &str| Cell::from(value.clone().unwrap_or_else(|| none.to_owned()));
    let mut blocks = Vec::new();
    if entries.is_empty() {
        blocks.push(Block::paragraph("The files say the same."));
    } else {
        blocks.push(Block::Table(Table {
            caption: "Entries of the files that differ, inherited ones among them.".into(),
            columns: vec![
                Column::text("Entry"),
                Column::text("Before"),
                Column::text("After"),
                Column::text("Written at"),
            ],
            rows: entries
                .iter()
                .map(|entry| {
                    vec![
                        Cell::code(&entry.entry),
                        or_none(&entry.before, "(not there)"),
                        or_none(&entry.after, "(gone)"),
                        Cell::code(&entry.at),
                    ]
                })
                .collect(),
        }));
    }
    if !unexplained.is_empty() {
        blocks.push(Block::paragraph(
            "What decides the results differs all the same (readings, rules, effects, or the program):",
        ));
        let lines = unexplained.iter().take(MOST_UNEXPLAINED).map(|difference| escaped(&difference.to_string()).into());
        blocks.push(Block::List(lines.collect()));
    }
    Section { id: "definitions", title: "What the files say".into(), blocks }
}

/// What became of the results, job by job.
fn results(names: &[&str], reports: &[PassReport<'_>; 2]) -> Section {
    let mut blocks = Vec::new();
    let mut has_untuned = false;
    let (mut same, mut without): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    for name in names {
        let [old, new] = reports.each_ref().map(|report| report.results.iter().find(|job| job.name == *name));
        if old.is_none() && new.is_none() {
            without.push(name);
            continue;
        }
        let [old, new] = [old, new].map(|job| job.map(essentials).unwrap_or_default());
        let rows = beside(&old, &new);
        if rows.is_empty() {
            same.push(name);
            continue;
        }
        has_untuned |= old.iter().chain(&new).any(|(name, _)| name.contains("untuned"));
        let (what, gone) = (rows.len(), old.len().max(new.len()));
        blocks.push(Block::Table(Table {
            caption: format!(
                "Job {name}: {what} of {} {}.",
                counted(gone, "figure"),
                if what == 1 { "differs" } else { "differ" }
            )
            .into(),
            columns: vec![Column::text("Figure"), Column::text("Before"), Column::text("After")],
            rows,
        }));
    }
    if has_untuned {
        let [before, after] = reports.each_ref().map(|report| report.untuned());
        blocks.push(Block::paragraph(match before == after {
            true => format!("Untuned: the model {before}."),
            false => format!("Untuned: the model {before} before, {after} after."),
        }));
    }
    if !same.is_empty() {
        blocks.push(Block::paragraph(format!("The same in both: {}.", same.join(", "))));
    }
    if !without.is_empty() {
        blocks.push(Block::paragraph(format!("Without a result in both: {}.", without.join(", "))));
    }
    Section { id: "results", title: "What became of the results".into(), blocks }
}

/// The figures that differ.
fn beside(old: &[(String, String)], new: &[(String, String)]) -> Vec<Vec<Cell>> {
    let get = |rows: &[(String, String)], name: &str| {
        rows.iter().find(|(other, _)| other == name).map(|(_, text)| text.clone())
    };
    let gone = old.iter().filter(|(name, _)| get(new, name).is_none());
    let rows = new.iter().chain(gone).filter_map(|(name, _)| {
        let (before, after) = (get(old, name), get(new, name));
        let or_none = |text: &Option<String>| Cell::from(text.clone().unwrap_or_else(|| "(none)".to_owned()));
        (before != after).then(|| vec![name.clone().into(), or_none(&before), or_none(&after)])
    });
    rows.collect()
}
