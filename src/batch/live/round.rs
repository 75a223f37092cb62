//! A round: the study is loaded, run and rendered, all into memory.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::page::{Kind, Served};
use crate::batch::archive::rendered;
use crate::batch::load::{load, parents};
use crate::batch::next_pass::offers;
use crate::batch::prepared::{Prepared, prepare};
use crate::batch::{BatchError, Executed, Reading};
use crate::document::Diagnostic;
use crate::report::INDEX;
use crate::report::archive::record::{FILE_NAME as RECORD, Record};
use crate::report::archive::{ArchivedPass, ArchivedStudy, RenderedPage, index_page, study_page};
use crate::report::history::{PassErrors, Split};
use crate::report::number::fixed;
use crate::report::terminal::escaped;
use crate::report::view::untuned;
use crate::runner::Outcome;
use crate::runner::manifest::{FILE_NAME as MANIFEST, FileRecord};

/// What a round gave.
pub struct Round {
    /// The passes with their results.
    pub(super) executed: Executed,
    /// What is served, by path.
    pub(super) pages: BTreeMap<String, Served>,
    /// The path of the page to begin with.
    pub(super) home: String,
    /// The error of each pass, in words, by its file.
    pub(super) errors: BTreeMap<String, String>,
    /// What should be known of the files.
    pub(super) notes: Vec<String>,
}

/// Why a round gave nothing.
#[derive(Debug)]
pub enum RoundError {
    /// It was stopped.
    Stopped,
    /// Something is wrong: as the terminal shows it.
    Wrong(String),
}

impl From<BatchError> for RoundError {
    fn from(error: BatchError) -> Self {
        Self::Wrong(error.to_string().trim_end().to_owned())
    }
}

/// Loads the passes below these paths, has `run` run their jobs, and renders them. `run` gives nothing where it was stopped.
///
/// # Errors
/// What is wrong with the files, or keeps all jobs from running; that it was stopped.
pub fn round(
    paths: &[PathBuf],
    reading: &Reading,
    run: impl FnOnce(Prepared) -> Result<Executed, BatchError>,
) -> Result<Round, RoundError> {
    let loaded = load(paths, reading)?;
    let mut notes: Vec<String> = Vec::new();
    let mut note = |text: String| {
        if !notes.contains(&text) {
            notes.push(text);
        }
    };
    loaded.notes.iter().for_each(|text| note(text.trim_end().to_owned()));
    let older = parents(&loaded.passes, reading);
    let prepared = prepare(loaded, older, |_, _, _| true)?;
    let refused = prepared.passes().iter().flat_map(|pass| &pass.refused);
    let wrong: Vec<&Diagnostic> = refused.flat_map(|refused| &refused.diagnostics).collect();
    wrong.into_iter().for_each(|diagnostic| note(diagnostic.render(reading.coloured)));
    let executed = run(prepared)?;
    if executed.is_interrupted {
        return Err(RoundError::Stopped);
    }
    for pass in &executed.passes {
        for id in &pass.jobs {
            let Some(Outcome::Failed(error)) = executed.summary.outcomes.get(id) else { continue };
            let name = executed.plan.find(id).map_or(id.as_str(), |position| &executed.plan.nodes()[position].name);
            note(format!("{}: {name} failed: {error}", pass.file));
        }
    }
    let mut round =
        Round { pages: BTreeMap::new(), home: format!("/{INDEX}.html"), errors: BTreeMap::new(), notes, executed };
    round.render()?;
    Ok(round)
}

impl Round {
    fn render(&mut self) -> Result<(), BatchError> {
        let mut passes = Vec::new();
        let mut study = String::new();
        for pass in &self.executed.passes {
            let Some((report, mut manifest)) = rendered(pass, &self.executed)? else { continue };
            let folder = pass.file.trim_end_matches(".json").to_owned();
            study = crate::batch::archive::study_name(&pass.study);
            let base = format!("/{study}/{folder}");
            for (name, bytes) in report.files() {
                manifest.add_output(&name, bytes);
                let mut page = Served::new(&name, bytes);
                if page.kind == Kind::Page {
                    page.offers =
                        offers(pass, &self.executed).into_iter().map(|own| (pass.file.clone(), own)).collect();
                }
                self.pages.insert(format!("{base}/{name}"), page);
            }
            let manifest_text = manifest.text()?;
            let manifest_file = FileRecord::of(manifest_text.as_bytes());
            self.pages.insert(format!("{base}/{MANIFEST}"), Served::new(MANIFEST, manifest_text.as_bytes()));
            self.home = format!("{base}/report.html");
            let unreadable = |error: String| BatchError::job(format!("{}: {RECORD}: {error}", escaped(&pass.shown)));
            let record = Record::read(report.record_json.as_bytes()).map_err(unreadable)?;
            if let Some(errors) = record.pass_errors() {
                self.errors.insert(pass.file.clone(), stated(&errors));
            }
            passes.push(ArchivedPass { folder, record, manifest, manifest_file });
        }
        if passes.is_empty() {
            return Ok(());
        }
        let study = ArchivedStudy { folder: study, passes };
        let rendered = |page| RenderedPage::new(&page).map_err(|error| BatchError::job(error.to_string()));
        let of_study = rendered(study_page::page(&study, std::slice::from_ref(&study)))?.html;
        self.pages.insert(format!("/{}/{INDEX}.html", study.folder), Served::new("index.html", of_study.as_bytes()));
        let over_all = rendered(index_page::page(&[study]))?.html;
        self.pages.insert(format!("/{INDEX}.html"), Served::new("index.html", over_all.as_bytes()));
        Ok(())
    }
}

/// The error of a pass: on readings held out where there are any, as delivered and tuned.
fn stated(errors: &PassErrors) -> String {
    let is_held_out = errors.readings.held_out > 0;
    let of = |split: &Split| if is_held_out { split.held_out } else { split.train };
    let untuned = untuned(!errors.adopted.is_empty());
    let states = [(untuned, &errors.rmse_k.delivered), ("tuned", &errors.rmse_k.tuned)];
    let words: Vec<String> =
        (states.into_iter()).filter_map(|(name, split)| Some(format!("{} K {name}", fixed(of(split)?, 2)))).collect();
    let on = if is_held_out { "on readings held out" } else { "on the readings of the fit" };
    format!("error {on}: {}", words.join(", "))
}
