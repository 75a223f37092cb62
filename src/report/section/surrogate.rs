//! The surrogate that answers in the model's place: how well it predicts runs of the model, and whether that is enough.

mod brief;

use crate::document::counted;
use crate::job::surrogate::{Kind, Output};
use crate::report::number::{NONE, percent, significant, with_unit};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;

/// Needs are stated down to this.
const SMALL: f64 = 0.000_001;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Surrogate);

/// The section on the surrogate; not without one.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(opening(name, output)));
        blocks.extend(warnings(output));
        blocks.push(outputs(output));
        blocks.extend(readings(output));
        blocks.extend(rounds(output));
    }
    (!blocks.is_empty()).then(|| Section { id: "surrogate", title: "Surrogate".into(), blocks })
}

/// What is said wherever results rest on a surrogate.
pub(super) fn notes(report: &PassReport<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (_, output) in report.outputs::<Kind>() {
        let words = format!("All results rest on a surrogate in the model's place. {}", in_a_line(output));
        blocks.push(Block::callout(Tone::Note, Text::with_names(&words)));
        blocks.extend(warnings(output));
    }
    blocks
}

/// Runs and errors in a line.
fn in_a_line(output: &Output) -> String {
    let errors: Vec<String> = (output.outputs.iter())
        .map(|own| {
            let share = own.share.map_or_else(String::new, |share| format!(" ({} of its spread)", percent(share, 2)));
            format!("{} for `{}`{share}", with_unit(&significant(own.error, 2), &own.unit), own.output)
        })
        .collect();
    format!(
        "It was trained on {} of the model; its cross-validated error is {}.",
        counted(usize::try_from(output.runs).unwrap_or(usize::MAX), "run"),
        errors.join(", ")
    )
}

fn warnings(output: &Output) -> Vec<Block> {
    let sentence = |finding: &String| {
        let mut characters = finding.chars();
        let first = characters.next().map(|c| c.to_ascii_uppercase().to_string()).unwrap_or_default();
        Block::callout(Tone::Warning, Text::with_names(&format!("{first}{}.", characters.as_str())))
    };
    output.findings.iter().map(sentence).collect()
}

fn opening(name: &str, output: &Output) -> Text {
    let words = format!(
        ": a Gaussian process for each output over {} in place of {}. {} lie within the priors and the inputs' ranges, {} where readings \
         or requirements needed them. The error of each output is a sum of standard normal parameters, some of them its values at anchors: it \
         has the process' standard deviation at each point, and goes together at near points. So every result carries it.",
        output.coordinates.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        output.model,
        counted(usize::try_from(output.first_runs).unwrap_or(usize::MAX), "run"),
        output.runs.saturating_sub(output.first_runs)
    );
    let mut text = Text::new("Job ").code(name);
    text.0.extend(Text::with_names(&words).0);
    text
}

fn outputs(output: &Output) -> Block {
    let rows = output.outputs.iter().map(|own| {
        vec![
            Cell::code(&own.output),
            own.unit.as_str().into(),
            significant(own.spread, 3).into(),
            significant(own.error, 2).into(),
            own.share.map_or_else(|| NONE.to_owned(), |share| percent(share, 2)).into(),
            significant(own.worst, 2).into(),
            own.error_where_needed.map_or_else(|| NONE.to_owned(), |error| significant(error, 2)).into(),
            significant(own.widened, 3).into(),
            own.beside_anchors.map_or_else(|| NONE.to_owned(), |share| percent(share, 2)).into(),
        ]
    });
    Block::Table(Table {
        caption: "Cross-validated error of each output: root mean square over runs that were left out one by one, hyperparameters \
                  fitted in ten folds; beside the output's standard deviation over the priors. Where needed: of the runs of the rounds \
                  alone. Widened: the factor on the process' standard deviation that the runs left out asked for. Beside anchors: the share of \
                  the error's variance that the parameters at the anchors leave; it counts as the same number of standard deviations at \
                  all points."
            .into(),
        columns: vec![
            Column::text("Output"),
            Column::text("Unit"),
            Column::number("Spread", ""),
            Column::number("Error", ""),
            Column::number("Of the spread", ""),
            Column::number("Largest", ""),
            Column::number("Where needed", ""),
            Column::number("Widened", ""),
            Column::number("Beside anchors", ""),
        ],
        rows: rows.collect(),
    })
}

fn readings(output: &Output) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = (output.readings.iter())
        .map(|own| {
            let status = match own.error <= own.noise {
                true if own.cross_validated <= own.noise => Status::Ok,
                true => Status::Caution,
                false => Status::Fail,
            };
            vec![
                Cell::code(&own.sensor),
                Cell::code(&own.measurement),
                own.unit.as_str().into(),
                significant(own.noise, 2).into(),
                Cell::marked(significant(own.error, 2), status),
                significant(own.cross_validated, 2).into(),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Error of the surrogate where the posterior lies, beside the noise of each sensor. It is marked as good below the noise, with \
                      caution where the cross-validated error over all runs exceeds the noise, and as bad above the noise."
                .into(),
            columns: vec![
                Column::text("Sensor"),
                Column::text("Measurement"),
                Column::text("Unit"),
                Column::number("Noise", ""),
                Column::number("Error", ""),
                Column::number("Cross-validated", ""),
            ],
            rows,
        })
    })
}

fn rounds(output: &Output) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = (output.rounds.iter())
        .flat_map(|round| round.needs.iter().map(move |need| (round.runs, need)))
        .map(|(runs, need)| {
            let status = if need.error <= need.allowed { Status::Ok } else { Status::Caution };
            vec![
                runs.to_string().into(),
                Cell::from(Text::with_names(&need.what)),
                Cell::marked(
                    if need.error < SMALL { format!("< {SMALL}") } else { significant(need.error, 2) },
                    status,
                ),
                significant(need.allowed, 2).into(),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption:
                "What the surrogate is needed for, after the first runs and after each round, until it is good enough."
                    .into(),
            columns: vec![
                Column::number("Runs", ""),
                Column::text("Needed for"),
                Column::number("Error", ""),
                Column::number("Allowed", ""),
            ],
            rows,
        })
    })
}
