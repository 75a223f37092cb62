//! The record of a validation, at the end of the pass that closes it: what was asked and what holds, the parameters with
//! their evidence, passes and decisions, the test, discrepancies and what became of them, the domain of validity, and what
//! identifies it all. It puts together what other sections say in detail.

mod outcome;
mod test;

use crate::document::counted;
use crate::report::history::{PassErrors, States};
use crate::report::number::{NONE, fixed};
use crate::report::page::{Block, Cell, Column, Section, Table, Text, Tone};
use crate::report::view::PassReport;
use crate::thermal::NodeKind;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// Hexadecimal digits of a hash that are shown; whole ones are under Provenance.
const DIGITS: usize = 16;

/// The section on the record; not where the pass closes no validation.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let closing = report.closing.as_ref()?;
    let mut blocks = vec![Block::paragraph(
        "This pass closes the validation. Its record follows, in the order of a correlation report; figures and full tables \
         stand in the sections before.",
    )];
    if let Some(note) = &report.reconstructed {
        blocks.push(Block::callout(Tone::Reconstructed, note.as_str()));
    }
    blocks.extend(outcome::requirements(report));
    blocks.extend(model(report));
    blocks.extend(outcome::parameters(report));
    blocks.extend(passes(report));
    blocks.extend(changes(report));
    blocks.extend(test::blocks(report));
    blocks.extend(outcome::discrepancies(report));
    if !closing.dispositions.is_empty() {
        let items =
            closing.dispositions.iter().map(|(name, text)| Text::default().strong(name).plain(": ").plain(text));
        blocks.push(Block::Heading("Disposition of discrepancies and anomalies".into()));
        blocks.push(Block::List(items.collect()));
    }
    blocks.push(Block::Heading("Domain of validity".into()));
    blocks.push(Block::List(closing.domain.iter().map(Text::new).collect()));
    blocks.extend(test::domain(report));
    if !closing.left.is_empty() {
        blocks.push(Block::Heading("Left to do".into()));
        blocks.push(Block::List(closing.left.iter().map(Text::new).collect()));
    }
    blocks.extend(configuration(report));
    Some(Section { id: "record", title: "Record of the validation".into(), blocks })
}

/// Physical, conceptual and simulation model, in numbers.
fn model(report: &PassReport<'_>) -> Vec<Block> {
    let count = |wanted: fn(&NodeKind) -> bool| report.model.nodes.iter().filter(|node| wanted(&node.kind)).count();
    let nodes = format!(
        "{} that store heat, {} arithmetic, {} of given temperature",
        count(|kind| matches!(kind, NodeKind::Diffusion { .. })),
        count(|kind| matches!(kind, NodeKind::Arithmetic)),
        count(|kind| matches!(kind, NodeKind::Boundary { .. }))
    );
    let mut rows = vec![
        ("Conceptual model".into(), Text::new(report.model.title.clone())),
        ("Nodes".into(), nodes.into()),
        ("Elements".into(), counted(report.model.elements.len(), "element").into()),
        ("Drawing and equations' coefficients".into(), "section Thermal model".into()),
    ];
    if !report.adopted.is_empty() {
        let names: Vec<&str> = report.adopted.iter().map(|effect| effect.name.as_str()).collect();
        rows.push(("Adopted effects".into(), names.join(", ").into()));
    }
    vec![Block::Heading("Model".into()), Block::Definitions(rows)]
}

fn error(states: &States) -> String {
    let best = |split: &crate::report::history::Split| split.held_out.or(split.train);
    let text = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, 2));
    format!("{} \u{2192} {}", text(best(&states.delivered)), text(best(&states.tuned)))
}

/// Every pass with what it decided, and the jobs that are its evidence.
fn passes(report: &PassReport<'_>) -> Vec<Block> {
    let Some(history) = &report.history else { return Vec::new() };
    let row = |pass: &PassErrors| {
        let jobs: Vec<&str> = pass.calibration.iter().chain(&pass.comparison).map(String::as_str).collect();
        vec![
            Cell::code(&pass.pass),
            pass.title.clone().into(),
            if pass.added.is_empty() { NONE.to_owned() } else { pass.added.join(", ") }.into(),
            error(&pass.rmse_k).into(),
            super::history::evidence(pass, 1),
            if jobs.is_empty() { NONE.to_owned() } else { jobs.join(", ") }.into(),
        ]
    };
    vec![
        Block::Heading("Passes and decisions".into()),
        Block::Table(Table {
            caption: "Every pass with what it added, and its evidence: the error of readings held out (of all where none are), untuned \
                      (as delivered, or with adopted effects at nominal size) and tuned."
                .into(),
            columns: vec![
                Column::text("Pass"),
                Column::text("What it did"),
                Column::text("Added effects"),
                Column::number("RMSE", "K"),
                Column::number("Log evidence", ""),
                Column::text("Jobs"),
            ],
            rows: history.passes.iter().map(row).collect(),
        }),
    ]
}

/// Every parameter that was changed, with its justification.
fn changes(report: &PassReport<'_>) -> Vec<Block> {
    let heading = Block::Heading("Parameters changed, with justification".into());
    if report.changes.is_empty() {
        return vec![heading, Block::paragraph("No nominal value and no prior of the model's file was changed.")];
    }
    let rows = report.changes.iter().map(|change| {
        vec![
            Cell::code(&change.what),
            change.before.clone().into(),
            change.after.clone().into(),
            Text::with_names(&change.because).into(),
        ]
    });
    vec![
        heading,
        Block::Table(Table {
            caption: "Every nominal value and prior against the model's file.".into(),
            columns: vec![
                Column::text("Parameter"),
                Column::text("Model's file"),
                Column::text("Now"),
                Column::text("Justification"),
            ],
            rows: rows.collect(),
        }),
    ]
}

/// What identifies the configuration.
fn configuration(report: &PassReport<'_>) -> Vec<Block> {
    let short = |hash: &str| hash.chars().take(DIGITS).collect::<String>();
    let files = report.files.iter().map(|file| [format!("{} {}", file.role, file.path), short(&file.sha256)]);
    let jobs = report.results.iter().map(|job| [format!("job {}", job.name), short(&job.key)]);
    let engine = ["numeric engine".to_owned(), report.engine_version.clone()];
    let rows = files.chain(jobs).chain([engine]).map(|[what, id]| vec![what.into(), Cell::code(id)]);
    vec![
        Block::Heading("Configuration".into()),
        Block::Table(Table {
            caption: format!(
                "What identifies model, data and results: the first {DIGITS} digits of each hash, whole under Provenance."
            )
            .into(),
            columns: vec![Column::text("What"), Column::text("Id")],
            rows: rows.collect(),
        }),
    ]
}
