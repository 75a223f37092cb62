//! Figures that the study itself asks for: readings beside what the model and others say, contours of a quantity.

mod contours;
mod readings;

use crate::job::compare;
use crate::measurement::{Measurement, Phase, Rows};
use crate::report::page::{Block, Cell, Column, Figure, Section, Table, Tone};
use crate::report::view::PassReport;
use crate::study::figure::{Drawn, Estimate};

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The figures in the order of the pass; not without one.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for own in &report.figures {
        blocks.push(Block::Heading(own.name.clone()));
        blocks.extend(own.description.as_ref().map(|text| Block::paragraph(text.clone())));
        let (drawn, estimates): (Result<Figure, String>, &[Estimate]) = match &own.drawn {
            Drawn::Readings(readings) => (readings::figure(report, &own.name, readings), &readings.estimates),
            Drawn::Contours(contours) => (contours::figure(report, &own.name, contours), &[]),
        };
        blocks.push(match drawn {
            Ok(figure) => Block::Figure(figure),
            Err(why) => Block::callout(Tone::Warning, format!("This figure cannot be drawn: {why}.")),
        });
        blocks.extend(sources(estimates));
    }
    (!blocks.is_empty()).then(|| Section { id: "figures", title: "Figures of this study".into(), blocks })
}

/// Where estimates of others come from.
fn sources(estimates: &[Estimate]) -> Vec<Block> {
    if estimates.is_empty() {
        return Vec::new();
    }
    let rows = estimates.iter().map(|own| {
        let kind = if own.reconstructed.is_some() { "reconstructed" } else { "as stated by the source" };
        vec![Cell::code(&own.name), kind.into(), own.source.clone().into()]
    });
    let mut blocks = vec![Block::Table(Table {
        caption: "Estimates of others in the figure above, with their sources.".into(),
        columns: vec![Column::text("Estimate"), Column::text("Numbers"), Column::text("Source")],
        rows: rows.collect(),
    })];
    let notes = estimates.iter().filter_map(|own| Some(format!("{}: {}", own.name, own.reconstructed.as_ref()?)));
    blocks.extend(notes.map(|note| Block::callout(Tone::Reconstructed, note)));
    blocks
}

/// The phases of a steady measurement with their positions, those left out altogether not among them.
fn phases(measurement: &Measurement) -> Vec<(usize, &Phase)> {
    match &measurement.rows {
        Rows::Steady(phases) => phases.iter().enumerate().filter(|(_, phase)| phase.ignored.is_none()).collect(),
        Rows::Transient { .. } => Vec::new(),
    }
}

/// What the last comparison with a measurement predicts of a sensor in a phase, tuned where it was tuned, and whether it was.
fn predicted(report: &PassReport<'_>, measurement: &str, sensor: &str, phase: &str) -> Option<(f64, bool)> {
    let of = |output: &compare::Output| {
        let row = output.rows.of(measurement, sensor).find(|row| row.phase == Some(phase))?;
        Some((row.predicted, row.predicted_tuned))
    };
    let rows = report.outputs::<compare::Kind>().filter_map(|(_, output)| of(output));
    rows.last().map(|(delivered, tuned)| tuned.map_or((delivered, false), |tuned| (tuned, true)))
}

/// Root mean square and largest magnitude; `None` without numbers.
fn spread(deviations: &[f64]) -> Option<[f64; 2]> {
    let known: Vec<f64> = deviations.iter().copied().filter(|own| own.is_finite()).collect();
    let squares: f64 = known.iter().map(|own| own * own).sum();
    let largest = known.iter().map(|own| own.abs()).fold(0.0, f64::max);
    (!known.is_empty()).then(|| [(squares / known.len() as f64).sqrt(), largest])
}
