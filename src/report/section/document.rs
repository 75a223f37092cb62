//! What the study's document says beside its title block: documents, assumptions, the test in words.

use crate::report::page::{Block, Cell, Column, Section, Table, Text, Tone};
use crate::report::view::PassReport;
use crate::study::StudyDocument;
use crate::study::document::Reference;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on the document; not where there is none, or it says no more than its title block.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let blocks = blocks(report.document.as_ref()?);
    let title = "Documents, assumptions and test".into();
    (!blocks.is_empty()).then_some(Section { id: "document", title, blocks })
}

/// Documents, assumptions, test.
pub fn blocks(document: &StudyDocument) -> Vec<Block> {
    let mut blocks = Vec::new();
    blocks.extend(document.summary.as_ref().map(|text| Block::paragraph(text.as_str())));
    blocks.extend(document.reconstructed.as_ref().map(|note| Block::callout(Tone::Reconstructed, note.as_str())));
    blocks.extend(documents(document));
    if !document.assumptions.is_empty() {
        blocks.push(Block::Heading("Assumptions".into()));
        blocks.push(Block::List(document.assumptions.iter().map(Text::new).collect()));
    }
    if !document.test.is_empty() {
        blocks.push(Block::Heading("The test in words".into()));
        let entries = document.test.iter().map(|(what, text)| (Text::new(what), Text::new(text)));
        blocks.push(Block::Definitions(entries.collect()));
    }
    blocks
}

fn documents(document: &StudyDocument) -> Vec<Block> {
    let kinds = [("applicable", &document.applicable), ("reference", &document.references)];
    let row = |kind: &str, own: &Reference| {
        vec![kind.into(), own.number.clone().into(), own.title.clone().into(), own.issue.clone().into()]
    };
    let rows: Vec<Vec<Cell>> =
        kinds.into_iter().flat_map(|(kind, list)| list.iter().map(move |own| row(kind, own))).collect();
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::Heading("Documents".into()),
        Block::Table(Table {
            caption: "Documents that bind (applicable) and that inform (reference).".into(),
            columns: vec![Column::text("Kind"), Column::text("Number"), Column::text("Title"), Column::text("Issue")],
            rows,
        }),
    ]
}
