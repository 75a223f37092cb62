//! Sections, plots, Markdown and HTML of the validation report; sees outputs and definitions, never a solver.
//!
//! [`render`] is a pure function of a [`PassReport`]: the same results give the same bytes. A section is a file in
//! `section/` and a line in its list; order, numbers, contents, Markdown and HTML come by themselves.

pub mod archive;
pub mod assemble;
pub mod body;
pub mod csv;
pub mod essentials;
pub mod headline;
pub mod history;
pub mod html;
pub mod known;
pub mod ladder;
pub mod live;
pub mod markdown;
pub mod number;
pub mod page;
pub mod plot;
pub mod required;
pub mod script;
pub mod seal;
pub mod section;
pub mod terminal;
pub mod title_block;
pub mod view;
mod write;

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};
use thiserror::Error;

use crate::job::KINDS;
use crate::job::array::Array;

use archive::record::Record;
pub use history::{History, PassErrors};
use page::{Page, Text};
use view::Siblings;
pub use view::{FileHash, JobEntry, ParameterChange, PassReport, Prior};
pub use write::{WriteError, write};

/// Name, without its ending, of the page over the passes of a study, and of that over all studies.
pub const INDEX: &str = "index";

/// A rendered report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderedReport {
    /// `report.md`.
    pub markdown: String,
    /// `report.html`.
    pub html: String,
    /// Name and contents of each `plots/NAME.svg`.
    pub figures: Vec<(String, String)>,
    /// Name and contents of each `plots/NAME.csv`: the numbers that the figure shows.
    pub data: Vec<(String, String)>,
    /// `results.json`.
    pub results_json: String,
    /// Name and contents of each `results/NAME.npy`: the arrays whose hashes stand in `results.json`.
    pub arrays: Vec<(String, Vec<u8>)>,
    /// `record.json`.
    pub record_json: String,
}

/// Why a report could not be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The HTML template failed.
    #[error(transparent)]
    Html(#[from] html::HtmlError),
    /// A result cannot be written as JSON.
    #[error("a result cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Renders a report. Pure: no file is read, no clock, no host.
pub fn render(report: &PassReport<'_>) -> Result<RenderedReport, RenderError> {
    let page = page(report);
    let figures = page::figures(&page);
    let svg = |(name, figure): &(String, &page::Figure)| {
        (name.clone(), figure.drawing.svg(name, name, &figure.alternative, true))
    };
    let arrays = arrays(report);
    Ok(RenderedReport {
        markdown: markdown::render(&page),
        html: html::render(&page, html::Beside::Files)?,
        figures: figures.iter().map(svg).collect(),
        data: figures.iter().map(|(name, figure)| (name.clone(), figure.drawing.numbers().csv.clone())).collect(),
        results_json: results_json(report, &arrays)?,
        arrays: arrays.into_iter().map(|(name, array)| (name, array.npy())).collect(),
        record_json: Record::of(report).text()?,
    })
}

/// The report as a document.
pub fn page(report: &PassReport<'_>) -> Page {
    let (sections, appendix) =
        body::divided(section::SECTIONS.iter().filter_map(|section| (section.build)(report)).collect());
    Page {
        title: report.title.clone(),
        subtitle: Text::new("Study ").code(&report.study).plain(", pass ").code(&report.pass_file),
        links: report.siblings.as_ref().map(links).unwrap_or_default(),
        title_block: report.document.iter().flat_map(|document| title_block::of_pass(document, report)).collect(),
        mark: report.document.as_ref().map(|document| title_block::mark_of_pass(document, report)).unwrap_or_default(),
        footer: Text::new(format!("Made by bmv, numeric engine {}. ", report.engine_version))
            .plain("The same files give the same bytes; the section on provenance has every hash."),
        sections,
        appendix,
    }
}

/// Links from a pass's report to its neighbours, its study and all studies.
fn links(siblings: &Siblings) -> Text {
    let mut text = Text::default();
    if let Some(previous) = &siblings.previous {
        text = text.plain("\u{2190} ").link(previous, &["..", previous, "report"]).plain(" \u{B7} ");
    }
    text = text.link("this study", &["..", INDEX]).plain(" \u{B7} ").link("all studies", &["..", "..", INDEX]);
    if let Some(next) = &siblings.next {
        text = text.plain(" \u{B7} ").link(next, &["..", next, "report"]).plain(" \u{2192}");
    }
    text
}

/// JSON Schema of the results of each kind of job, as they stand in `results.json` under `jobs.NAME.output`.
pub fn results_schema() -> Value {
    KINDS.iter().map(|kind| (kind.name().to_owned(), kind.output_schema())).collect::<Map<_, _>>().into()
}

/// Arrays of the results, equal ones once, by the names of their files.
fn arrays(report: &PassReport<'_>) -> BTreeMap<String, Array> {
    let (mut files, mut hashes) = (BTreeMap::new(), BTreeSet::new());
    for job in &report.results {
        for (name, array) in job.output.arrays() {
            if hashes.insert(array.sha256()) {
                let free = page::free(&page::slug(&format!("{} {name}", job.name)), |name| files.contains_key(name));
                files.insert(free, array);
            }
        }
    }
    files
}

/// All outputs as one JSON document in SI units, jobs by name; a number that is not finite is `null`. `files` has the arrays
/// that lie beside it, by hash.
fn results_json(report: &PassReport<'_>, arrays: &BTreeMap<String, Array>) -> Result<String, serde_json::Error> {
    let mut jobs = Map::new();
    for job in &report.results {
        let output = job.output.to_json()?;
        jobs.insert(job.name.clone(), json!({ "kind": job.output.kind(), "key": job.key, "output": output }));
    }
    let files = arrays.iter().map(|(name, array)| (array.sha256(), json!(seal::array_path(name))));
    let mut whole = json!({
        "format": "bmv-results/1",
        "study": report.study,
        "pass": report.pass_file,
        "engine_version": report.engine_version,
        "reconstructed": report.reconstructed,
        "jobs": jobs,
    });
    if !arrays.is_empty() {
        whole["files"] = Value::Object(files.collect());
    }
    Ok(serde_json::to_string_pretty(&whole)? + "\n")
}
