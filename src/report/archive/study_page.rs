//! The page over the passes of a study: what came of each, the error from state to state, requirements, parameters and
//! changes over the passes, and how to verify it all.

use crate::report::history::{History, PassErrors, Split};
use crate::report::number::{NONE, fixed};
use crate::report::page::{Block, Cell, Column, Figure, Page, Section, Table, Text, Tone};
use crate::report::plot::Axis;
use crate::report::plot::{Bar, bar_chart, palette};
use crate::report::section::{compliance, document, error_by_pass};
use crate::report::title_block;

use super::study_tables::{changes, flight, parameters, requirements, statements};
use super::{ArchivedPass, ArchivedStudy, counterparts, timeline};

/// The page; `all` are the studies whose reports lie beside it, itself among them.
pub fn page(study: &ArchivedStudy, all: &[ArchivedStudy]) -> Page {
    let document = study.document();
    let mut subtitle = Text::new("Study ").code(&study.folder);
    if document.is_some() {
        subtitle = subtitle.plain(": all passes");
    }
    let sections = [
        Some(passes(study)),
        error(study),
        timeline::section(study),
        requirements(study),
        statements(study),
        parameters(study),
        changes(study),
        flight(study),
        counterparts::section(study, all),
        document_section(study),
        Some(verification(study)),
    ];
    Page {
        title: study.title(),
        subtitle,
        links: Text::default().link("all studies", &["..", crate::report::INDEX]),
        title_block: document.map(title_block::of_study).unwrap_or_default(),
        mark: document.map(title_block::mark_of_study).unwrap_or_default(),
        footer: Text::new(
            "Made by bmv from the records of the reports below this folder; the same reports give the same bytes.",
        ),
        sections: sections.into_iter().flatten().collect(),
        ..Page::default()
    }
}

/// A pass as a link to its report.
pub(super) fn link(pass: &ArchivedPass) -> Text {
    Text::default().link(name(pass), &[&pass.folder, "report"])
}

/// A pass's name.
pub(super) fn name(pass: &ArchivedPass) -> &str {
    pass.record.pass.trim_end_matches(".json")
}

fn passes(study: &ArchivedStudy) -> Section {
    let row = |pass: &ArchivedPass| {
        let errors = pass.record.pass_errors();
        let parent = errors.as_ref().and_then(|own| own.parent.clone()).unwrap_or_else(|| NONE.to_owned());
        let verdicts = &pass.record.requirements;
        let verdicts = if verdicts.is_empty() { NONE.to_owned() } else { compliance::counts(verdicts) };
        let outcome = if pass.record.outcome.is_empty() { NONE } else { pass.record.outcome.as_str() };
        vec![
            Cell::from(link(pass)),
            pass.record.title.clone().into(),
            parent.trim_end_matches(".json").into(),
            outcome.into(),
            errors.as_ref().map_or_else(|| NONE.to_owned(), best).into(),
            verdicts.into(),
        ]
    };
    let mut blocks = vec![Block::Table(Table {
        caption:
            "The passes of the study. Error: root mean square of measured minus predicted on readings held out (of all \
                  where none are), untuned (as delivered, or with adopted effects at nominal size) \u{2192} tuned."
                .into(),
        columns: vec![
            Column::text("Pass"),
            Column::text("Title"),
            Column::text("After"),
            Column::text("What came out"),
            Column::number("Error", "K"),
            Column::text("Requirements"),
        ],
        rows: study.passes.iter().map(row).collect(),
    })];
    let left_out = study.document().into_iter().flat_map(|document| &document.not_archived);
    let left_out: Vec<Text> = left_out
        .filter(|(pass, _)| study.passes.iter().all(|own| own.record.pass != *pass))
        .map(|(pass, why)| Text::default().code(pass).plain(format!(" is not kept with these reports: {why}")))
        .collect();
    if !left_out.is_empty() {
        blocks.push(Block::List(left_out));
    }
    let mut notes: Vec<&str> = Vec::new();
    for note in study.passes.iter().filter_map(|pass| pass.record.reconstructed.as_deref()) {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    blocks.extend(notes.into_iter().map(|note| Block::callout(Tone::Reconstructed, note)));
    Section { id: "passes", title: "Passes".into(), blocks }
}

/// `3.70 → 1.90`: the error that counts, untuned and tuned.
pub(super) fn best(errors: &PassErrors) -> String {
    let of = |split: &Split| split.held_out.or(split.train);
    let text = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, 2));
    format!("{} \u{2192} {}", text(of(&errors.rmse_k.delivered)), text(of(&errors.rmse_k.tuned)))
}

/// The errors of the passes, each after its parents.
fn history(study: &ArchivedStudy) -> History {
    History { passes: study.passes.iter().filter_map(|pass| pass.record.pass_errors()).collect() }
}

fn error(study: &ArchivedStudy) -> Option<Section> {
    let history = history(study);
    let mut section = error_by_pass(&history)?;
    let parts: [(&str, &str, Pick); 2] =
        [("held-out", "held out", |split| split.held_out), ("fitting", "for fitting", |split| split.train)];
    let figures = parts.into_iter().filter_map(|(id, words, pick)| waterfall(&history, id, words, pick));
    let mut figures = figures.map(Block::Figure).collect::<Vec<_>>().into_iter();
    let place = section.blocks.iter().position(|block| matches!(block, Block::Table(_))).unwrap_or(0);
    // The error that counts stands open.
    let first = figures.next();
    let has_bars = first.is_some();
    let others: Vec<Block> = figures.collect();
    let folded = (!others.is_empty()).then(|| Block::Details("Error on the readings for fitting".into(), others));
    section.blocks.splice(place..place, first.into_iter().chain(folded));
    // The curves show what the bars show.
    let folded = section.blocks.into_iter().enumerate().map(|(at, block)| match block {
        Block::Figure(_) if has_bars && at > place => Block::Details("Error by pass as curves".into(), vec![block]),
        other => other,
    });
    section.blocks = folded.collect();
    Some(section)
}

/// Which readings an error is of.
type Pick = fn(&Split) -> Option<f64>;

/// The error from state to state as a waterfall: what each step took off or added.
fn waterfall(history: &History, id: &str, words: &str, pick: Pick) -> Option<Figure> {
    let mut bars: Vec<Bar> = Vec::new();
    let mut said = Vec::new();
    let total = |label: String, value: f64| Bar {
        label,
        from: 0.0,
        value,
        interval: None,
        text: format!("{} K", fixed(value, 2)),
        colour: palette::MUTED,
    };
    let step = |label: String, from: f64, value: f64| Bar {
        label,
        from,
        value,
        interval: None,
        text: format!("{} \u{2192} {} K", fixed(from, 2), fixed(value, 2)),
        colour: if value <= from { palette::GREEN } else { palette::VERMILION },
    };
    for pass in history.measured() {
        let name = pass.pass.trim_end_matches(".json");
        let before = history.before(pass).filter(|before| before.has_readings_of(pass));
        let delivered = pick(&pass.rmse_k.delivered);
        let start = match before.and_then(|before| pick(&before.rmse_k.tuned)) {
            Some(earlier) => Some(earlier),
            None => {
                bars.extend(delivered.map(|value| total(format!("{name}, {}", pass.untuned_in_words()), value)));
                delivered
            }
        };
        let (Some(from), Some(value)) = (start, pick(&pass.rmse_k.tuned)) else { continue };
        let what = if before.is_none() && !pass.adopted.is_empty() {
            format!("{name}, tuned, nothing further added")
        } else if pass.added.is_empty() {
            format!("{name}, tuned")
        } else {
            format!("{name}, tuned with {}", pass.added.join(", "))
        };
        said.push(format!("{what} {} K", fixed(value, 2)));
        bars.push(step(what, from, value));
    }
    if bars.len() < 2 {
        return None;
    }
    Some(Figure {
        id: format!("waterfall-{id}"),
        drawing: bar_chart(&Axis::new(format!("RMSE, readings {words} [K]")), &bars, None),
        caption: format!(
            "Error on the readings {words}, from state to state: grey before any tuning; green what a step took off, vermilion what it \
             added, each with the error before it and after it. A pass begins anew where its readings are others."
        )
        .into(),
        alternative: format!("Bars of the error by state: {}.", said.join("; ")),
    })
}

fn document_section(study: &ArchivedStudy) -> Option<Section> {
    let blocks = document::blocks(study.document()?);
    let title = "Documents, assumptions and test".into();
    (!blocks.is_empty()).then_some(Section { id: "document", title, blocks })
}

fn verification(study: &ArchivedStudy) -> Section {
    let example = study.passes.last().map_or("pass-1", |pass| pass.folder.as_str());
    let rows = study.passes.iter().map(|pass| {
        vec![Cell::from(link(pass)), Cell::code(&pass.manifest.command), Cell::code(pass.manifest_file.sha256.as_str())]
    });
    let mut blocks = vec![
        Block::Paragraph(
            Text::new("In this folder ").code("bmv verify .").plain(", of one pass ").code(format!("bmv verify {example}")).plain(
                ", computes every hash again and holds the files against one another. A manifest is proof \
                 where its own hash is known from a source that you trust: hold it against the hash below. The command of a \
                 pass, run in the project's folder, gives the same bytes again.",
            ),
        ),
        Block::Table(Table {
            caption: "Passes with the command that makes each report again and the SHA-256 of its manifest.json.".into(),
            columns: vec![Column::text("Pass"), Column::text("Command"), Column::text("SHA-256 of the manifest")],
            rows: rows.collect(),
        }),
        Block::Paragraph(
            Text::default()
                .code(super::ro_crate::FILE_NAME)
                .plain(" beside this page describes the same files, their inputs and what made them, as an RO-Crate 1.1."),
        ),
    ];
    let lacks = super::ro_crate::lacks(study);
    if !lacks.is_empty() {
        blocks.push(Block::callout(
            Tone::Note,
            Text::new(format!(
                "The RO-Crate is not complete: the study states no {}. Write it in its ",
                lacks.join(" and no ")
            ))
            .code(crate::study::document::FILE)
            .plain("."),
        ));
    }
    Section { id: "verification", title: "Verification".into(), blocks }
}
