//! Where every number comes from: jobs with their keys, files with their hashes, the engine, the command.

use crate::report::page::{Block, Cell, Column, Section, Table, Text};
use crate::report::view::PassReport;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on provenance; always there.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut entries = vec![
        ("Made again by".into(), Text::default().code(&report.command)),
        ("Numeric engine".into(), Text::default().code(&report.engine_version)),
    ];
    entries.extend(report.origin_sha256.as_ref().map(|hash| ("Origin".into(), Text::default().code(hash))));
    let mut blocks = vec![Block::Definitions(entries)];
    if report.origin_sha256.is_some() {
        blocks.push(Block::Heading("How to verify it".into()));
        blocks.push(Block::Paragraph(
            Text::new("Origin is the SHA-256 of all that ")
                .code("manifest.json")
                .plain(" says of inputs, jobs, results and engine. The last line of this document, its seal, has the same, with the \
                        hashes of its own text and of the files beside it. ")
                .code("bmv verify DIR")
                .plain(", DIR being the folder of this report, computes all of them again from the files. The hash of the manifest \
                        itself cannot stand in what it lists: it is on the page of the study, one folder above."),
        ));
    }
    blocks.extend([Block::paragraph(
        "A job's key is the SHA-256 of everything that decides its result: resolved model, parameters, hashes of \
             the data, settings, seed and the version of the algorithm. The same key means the same numbers, to the \
             last bit, on any x86-64 Linux machine and any number of cores.",
    )]);
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
