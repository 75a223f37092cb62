//! Where a prediction goes beyond what the calibration behind it was tested with: inputs of an environment, and temperatures
//! that were measured and are predicted.

use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::job::predict::Kind;
use crate::report::number::Shown;
use crate::report::page::{Block, Cell, Column, Table, Text, Tone};
use crate::report::view::PassReport;

use super::tested::measured_as;
use crate::report::section::propagation::{nominal_cases, quantile};

/// Entries that a warning names.
const MOST_NAMED: usize = 4;

/// An input or a quantity beyond its tests.
struct Beyond {
    job: String,
    environment: String,
    is_input: bool,
    name: String,
    tested: String,
    value: String,
}

/// All that lies beyond its tests; of a quantity the median of its prediction counts.
fn beyond(report: &PassReport<'_>) -> Vec<Beyond> {
    let mut out: Vec<Beyond> = Vec::new();
    for tested in &report.tested {
        let Some((_, output)) = report.outputs::<Kind>().find(|(name, _)| *name == tested.job) else { continue };
        for case in nominal_cases(&output.posterior) {
            let one = |name: &str, is_input: bool, range: &TestedRange, shown: &Shown, value: f64| Beyond {
                job: tested.job.clone(),
                environment: case.environment.clone(),
                is_input,
                name: name.to_owned(),
                tested: if range.lower == range.upper {
                    shown.text(range.lower)
                } else {
                    format!("{} to {}", shown.number(range.lower), shown.text(range.upper))
                },
                value: shown.text(value),
            };
            let environment = report.environments.iter().find(|own| own.name == case.environment);
            for (index, input) in report.model.inputs.iter().enumerate() {
                let range = tested.inputs.iter().find(|range| range.input == input.name);
                let value = environment.and_then(|own| own.inputs.get(index));
                let Some((range, &value)) = range.zip(value).filter(|(range, value)| range.outside(**value).is_some())
                else {
                    continue;
                };
                out.push(one(&input.name, true, range, &Shown::written(&input.unit), value));
            }
            for quantity in &case.quantities {
                let own = report.model.quantities.iter().find(|own| own.name == quantity.name);
                let name = own.map_or(quantity.name.as_str(), |own| measured_as(report.model, own));
                let Some(range) = tested.quantities.iter().find(|range| range.input == name) else { continue };
                let median = quantile(quantity, 0.5);
                if range.outside(median).is_some() {
                    let shown = Shown::quantity(&quantity.unit, quantity.is_temperature);
                    out.push(one(&quantity.name, false, range, &shown, median));
                }
            }
        }
    }
    out
}

/// The warning of the first screen.
pub(in crate::report::section) fn warning(report: &PassReport<'_>) -> Option<Block> {
    let all = beyond(report);
    if all.is_empty() {
        return None;
    }
    let mut text = Text::default().strong("Beyond what was tested").plain(": ");
    let mut last = "";
    for (position, own) in all.iter().take(MOST_NAMED).enumerate() {
        text = text.plain(if position == 0 { "" } else { "; " });
        if own.environment != last {
            text = text.code(&own.environment).plain(": ");
            last = &own.environment;
        }
        let (verb, was) = if own.is_input { (" ", "tested") } else { (" predicted ", "measured") };
        text = text.code(&own.name).plain(format!("{verb}{}, {was} {}", own.value, own.tested));
    }
    let more = all.len() - all.len().min(MOST_NAMED);
    let more = if more > 0 { format!("; and {more} more, listed with the prediction") } else { String::new() };
    let text = text.plain(format!("{more}. There the prediction is an extrapolation that no test has judged."));
    Some(Block::callout(Tone::Warning, text))
}

/// The table of the prediction.
pub(super) fn table(report: &PassReport<'_>, job: &str) -> Option<Block> {
    let all = beyond(report);
    let row = |own: &Beyond| {
        let what = if own.is_input { "input" } else { "predicted, median" };
        vec![
            Cell::code(&own.environment),
            Cell::code(&own.name),
            what.into(),
            own.tested.clone().into(),
            own.value.clone().into(),
        ]
    };
    let rows: Vec<_> = all.iter().filter(|own| own.job == job).map(row).collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Limits of validity: what this prediction has beyond the measurements behind its calibration. There it is an \
                      extrapolation."
                .into(),
            columns: vec![
                Column::text("Environment"),
                Column::text("Name"),
                Column::text("What"),
                Column::text("Tested"),
                Column::text("Here"),
            ],
            rows,
        })
    })
}
