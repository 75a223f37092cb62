//! The page over the reports of all studies.

use crate::document::counted;
use crate::report::number::NONE;
use crate::report::page::{Block, Cell, Column, Page, Section, Table, Text};
use crate::report::section::compliance;

use super::ArchivedStudy;
use super::study_page::{best, name};

/// The page; studies in the order of their names.
pub fn page(studies: &[ArchivedStudy]) -> Page {
    let passes = studies.iter().map(|study| study.passes.len()).sum::<usize>();
    Page {
        title: "Validation reports".into(),
        subtitle: format!("{}, {}", counted(studies.len() as u64, "study"), counted(passes as u64, "pass")).into(),
        footer: Text::new(
            "Made by bmv from the records of the reports below this folder; the same reports give the same bytes.",
        ),
        sections: vec![of_studies(studies), of_passes(studies), verification()],
        ..Page::default()
    }
}

fn of_studies(studies: &[ArchivedStudy]) -> Section {
    let row = |study: &ArchivedStudy| {
        let document = study.document();
        let number = document.map_or_else(|| NONE.to_owned(), |own| format!("{}, issue {}", own.number, own.issue));
        let date = document.map_or_else(|| NONE.to_owned(), |own| own.date.clone());
        let last = study.passes.iter().rev().find(|pass| !pass.record.outcome.is_empty());
        let outcome = last.map_or_else(|| NONE.to_owned(), |pass| format!("{}: {}", name(pass), pass.record.outcome));
        vec![
            Cell::from(Text::default().link(study.title(), &[&study.folder, crate::report::INDEX])),
            number.into(),
            date.into(),
            study.passes.len().to_string().into(),
            outcome.into(),
        ]
    };
    Section {
        id: "studies",
        title: "Studies".into(),
        blocks: vec![Block::Table(Table {
            caption: "Studies whose reports lie here, with what came out of the last pass that says it.".into(),
            columns: vec![
                Column::text("Study"),
                Column::text("Document"),
                Column::text("Date"),
                Column::number("Passes", ""),
                Column::text("What came out"),
            ],
            rows: studies.iter().map(row).collect(),
        })],
    }
}

fn of_passes(studies: &[ArchivedStudy]) -> Section {
    let rows = studies.iter().flat_map(|study| {
        study.passes.iter().map(move |pass| {
            let errors = pass.record.pass_errors();
            let verdicts = &pass.record.requirements;
            let verdicts = if verdicts.is_empty() { NONE.to_owned() } else { compliance::counts(verdicts) };
            vec![
                Cell::code(&study.folder),
                Cell::from(Text::default().link(name(pass), &[&study.folder, &pass.folder, "report"])),
                pass.record.title.clone().into(),
                errors.as_ref().map_or_else(|| NONE.to_owned(), best).into(),
                verdicts.into(),
            ]
        })
    });
    Section {
        id: "passes",
        title: "Passes".into(),
        blocks: vec![Block::Table(Table {
            caption: "All passes. Error: root mean square of measured minus predicted on readings held out (of all where none are), untuned \
                      (as delivered, or with adopted effects at nominal size) \u{2192} tuned."
                .into(),
            columns: vec![
                Column::text("Study"),
                Column::text("Pass"),
                Column::text("Title"),
                Column::number("Error", "K"),
                Column::text("Requirements"),
            ],
            rows: rows.collect(),
        })],
    }
}

fn verification() -> Section {
    Section {
        id: "verification",
        title: "Verification".into(),
        blocks: vec![Block::Paragraph(
            Text::new("Every pass has a manifest with the hashes of its inputs, jobs and files: ")
                .code("bmv verify DIR")
                .plain(
                    " computes them again, DIR being the folder of the pass. The page of a study has the hash of each \
                     manifest. This page lists the reports that lie below its folder; one that a study's document leaves \
                     out of the archive is not among them.",
                ),
        )],
    }
}
