//! Adopted effects: what the pass adds to the model's physics, where, with which priors, and why.

use crate::report::page::{Block, Cell, Column, Section, Table, Text};
use crate::report::view::PassReport;

use super::Entry;
use super::problem::{parameter_shown, prior_words};

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on adopted effects; none where the pass adopts none.
fn build(report: &PassReport<'_>) -> Option<Section> {
    if report.adopted.is_empty() {
        return None;
    }
    let effects = report
        .adopted
        .iter()
        .map(|effect| {
            let mut place = effect.place.join(", ");
            for (input, bound) in &effect.inputs {
                place.push_str(&format!("; {input}: {bound}"));
            }
            let mut because = effect.because.clone();
            if let Some(evidence) = &effect.evidence {
                because.push_str(&format!(" (job {} of {})", evidence.job, evidence.pass));
            }
            let applies = if effect.applies_to.is_empty() {
                "every measurement and environment".to_owned()
            } else {
                effect.applies_to.join(", ")
            };
            vec![
                Cell::code(&effect.name),
                effect.title.clone().into(),
                Cell::code(&effect.equation),
                place.into(),
                applies.into(),
                Text::with_names(&because).into(),
                effect.source.clone().into(),
            ]
        })
        .collect();
    let mut blocks = vec![Block::Table(Table {
        caption: "Effects that this pass adds to the model.".into(),
        columns: vec![
            Column::text("Name"),
            Column::text("Effect"),
            Column::text("Equation"),
            Column::text("Where"),
            Column::text("Applies to"),
            Column::text("Because"),
            Column::text("Source"),
        ],
        rows: effects,
    })];
    let parameters = report.adopted.iter().flat_map(|effect| effect.parameters.clone());
    let rows: Vec<Vec<Cell>> = parameters
        .filter_map(|index| report.model.parameters.get(index))
        .map(|parameter| {
            let prior = report.priors.iter().find(|prior| prior.0 == parameter.name);
            let shown = parameter_shown(parameter, prior.map(|prior| &prior.1));
            vec![
                Cell::code(&parameter.name),
                shown.unit.clone().into(),
                prior.map_or_else(String::new, |prior| prior_words(&prior.1, &shown)).into(),
                parameter.description.clone().into(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        blocks.push(Block::Table(Table {
            caption: "Parameters of the adopted effects with their priors.".into(),
            columns: vec![
                Column::text("Parameter"),
                Column::text("Unit"),
                Column::text("Prior"),
                Column::text("Meaning"),
            ],
            rows,
        }));
    }
    Some(Section { id: "adopted", title: "Adopted effects".into(), blocks })
}
