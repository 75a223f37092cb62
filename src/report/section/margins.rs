//! Margins before and after calibration side by side: what a deterministic correlation leads to, the size or limit by every
//! rule, the probability that each buys, and what it costs.

pub mod bought;
mod brief;

use crate::document::counted;
use crate::job::compare::Deviation;
use crate::job::correlate::{Correlated, Ended, Kind, Method, Output};
use crate::report::number::{NONE, Shown, as_given, fixed, percent, significant};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Correlation);

/// The section on correlations and margins; not without a correlation, or without sizes by rule beside a prediction.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = bought::blocks(report);
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Heading(format!("Correlation {name}: {}", output.method.words())));
        blocks.push(Block::callout(Tone::Note, outcome(output)));
        blocks.push(deviations(output));
        blocks.push(parameters(output));
        blocks.extend(changes(output));
    }
    (!blocks.is_empty()).then(|| Section {
        id: "margins",
        title: "Margins before and after the test: conventional and probabilistic".into(),
        blocks,
    })
}

/// What a correlation achieved, in a sentence or two.
pub(super) fn outcome(output: &Output) -> String {
    let criteria = &output.criteria.title;
    let mut text = match output.ended {
        Ended::MetAsDelivered if output.changes.is_empty() => {
            format!("The delivered model keeps the criteria ({criteria}): nothing was changed.")
        }
        Ended::MetAsDelivered => {
            format!("The delivered model keeps the criteria ({criteria}); least squares comes closer.")
        }
        Ended::Met => match output.method {
            Method::OneAtATime => {
                format!("After {} the criteria are met ({criteria}).", counted(output.changes.len(), "change"))
            }
            Method::LeastSquares => format!("At the least sum of squares the criteria are met ({criteria})."),
        },
        Ended::NotMet => format!(
            "The criteria ({criteria}) are NOT met: no change of these parameters within their ranges comes closer. The model \
             lacks something, or a range is too narrow."
        ),
    };
    let at_bound: Vec<&str> =
        output.parameters.iter().filter(|own| own.at_bound).map(|own| own.name.as_str()).collect();
    if !at_bound.is_empty() {
        text.push_str(&format!(" At an end of its range: {}.", at_bound.join(", ")));
    }
    text.push_str(" Values of a correlation have no uncertainty: a margin by rule stands for it.");
    text
}

fn deviations(output: &Output) -> Block {
    let row = |what: &str, own: &Deviation| {
        let number = |value: f64| Cell::from(fixed(value, 2));
        vec![
            what.into(),
            own.count.to_string().into(),
            number(own.mean),
            number(own.sd),
            number(own.rmse),
            number(own.max),
            percent(own.within_limit, 0).into(),
        ]
    };
    let rows = [
        ("fitted, delivered", &output.before),
        ("fitted, correlated", &output.after),
        ("held out, delivered", &output.held_out_before),
        ("held out, correlated", &output.held_out_after),
    ];
    Block::Table(Table {
        caption: "Measured minus predicted, readings in kelvin.".into(),
        columns: vec![
            Column::text("Readings"),
            Column::number("Count", ""),
            Column::number("Mean", "K"),
            Column::number("Standard deviation", "K"),
            Column::number("RMSE", "K"),
            Column::number("Largest", "K"),
            Column::number("Within the limit", ""),
        ],
        rows: rows.iter().filter(|(_, own)| own.count > 0).map(|(what, own)| row(what, own)).collect(),
    })
}

/// How a parameter is shown: by the larger of its values.
fn shown(own: &Correlated) -> Shown {
    Shown::parameter_of(&own.unit, own.before.abs().max(own.after.abs()))
}

fn parameters(output: &Output) -> Block {
    let row = |own: &Correlated| {
        let shown = shown(own);
        let range = own.range.map(|end| as_given(shown.value(end)));
        let after = significant(shown.value(own.after), 4);
        vec![
            Cell::code(&own.name),
            shown.unit.clone().into(),
            as_given(shown.value(own.before)).into(),
            if own.at_bound { Cell::marked(after, Status::Caution) } else { after.into() },
            format!("{} to {}", range[0], range[1]).into(),
        ]
    };
    Block::Table(Table {
        caption: "Parameters that could be changed, before and after.".into(),
        columns: vec![
            Column::text("Parameter"),
            Column::text("Unit"),
            Column::number("Before", ""),
            Column::number("After", ""),
            Column::number("Range", ""),
        ],
        rows: output.parameters.iter().map(row).collect(),
    })
}

/// The changes one by one; of least squares the last alone says something, and stands above.
fn changes(output: &Output) -> Option<Block> {
    if output.method == Method::LeastSquares || output.changes.is_empty() {
        return None;
    }
    let of = |name: &str| output.parameters.iter().find(|own| own.name == name).map(shown);
    let rows = output.changes.iter().enumerate().map(|(index, change)| {
        let name = change.parameter.as_deref().unwrap_or(NONE);
        let shown = of(name).unwrap_or_else(|| Shown::written(""));
        let value = change.value.map_or_else(|| NONE.to_owned(), |value| significant(shown.value(value), 4));
        vec![
            (index + 1).to_string().into(),
            Cell::code(name),
            value.into(),
            shown.unit.clone().into(),
            fixed(change.rmse, 2).into(),
            fixed(change.max, 2).into(),
            Cell::marked(if change.met { "met" } else { "not met" }, Status::kept(change.met)),
        ]
    });
    let table = Table {
        caption: Text::new("The changes in their order: always the parameter that alone lowers the misfit most."),
        columns: vec![
            Column::number("Change", ""),
            Column::text("Parameter"),
            Column::number("Value", ""),
            Column::text("Unit"),
            Column::number("RMSE", "K"),
            Column::number("Largest", "K"),
            Column::text("Criteria"),
        ],
        rows: rows.collect(),
    };
    Some(Block::Details(format!("Changes one by one ({})", output.changes.len()), vec![Block::Table(table)]))
}
