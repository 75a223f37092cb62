//! Where every number comes from: jobs with their keys, files with their hashes, the engine, the command.

use crate::report::page::{Block, Cell, Column, Section, Table, Text};
use crate::report::view::PassReport;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on provenance; always there.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = vec![
        Block::Definitions(vec![
            ("Made again by".into(), Text::default().code(&report.command)),
            ("Numeric engine".into(), Text::default().code(&report.engine_version)),
        ]),
        Block::paragraph(
            "A job's key is the SHA-256 of everything that decides its result: resolved model, parameters, hashes of \
             the data, settings, seed and the version of the algorithm. The same key means the same numbers, to the \
             last bit, on any x86-64 Linux machine and any number of cores.",
        ),
    ];
    if !report.results.is_empty() {
        let rows = report
            .results
            .iter()
            .map(|job| vec![Cell::code(&job.name), job.output.kind().into(), Cell::code(&job.key)])
            .collect();
        blocks.push(Block::Table(Table {
            caption: "Jobs.".into(),
            columns: vec![Column::text("Job"), Column::text("Kind"), Column::text("Key")],
            rows,
        }));
    }
    if !report.files.is_empty() {
        let rows = report
            .files
            .iter()
            .map(|file| vec![Cell::code(&file.path), file.role.clone().into(), Cell::code(&file.sha256)])
            .collect();
        blocks.push(Block::Table(Table {
            caption: "Files that the results depend on.".into(),
            columns: vec![Column::text("File"), Column::text("Role"), Column::text("SHA-256")],
            rows,
        }));
    }
    Some(Section { id: "provenance", title: "Provenance".into(), blocks })
}
