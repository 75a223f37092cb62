//! Of the record: how was tested, what was predicted and measured before and after, and whether flight lies within it.

use crate::job::compare::{self, Deviation};
use crate::measurement::{Measurement, Rows};
use crate::report::number::{NONE, Shown, fixed, significant};
use crate::report::page::{Block, Cell, Column, Status, Table, Text};
use crate::report::section::prediction::tested::input_in_row;
use crate::report::view::PassReport;

/// Test configuration, stabilisation, heat balance, prediction against test.
pub(super) fn blocks(report: &PassReport<'_>) -> Vec<Block> {
    if report.measurements.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![Block::Heading("Test".into()), configuration(report)];
    for (name, output) in report.outputs::<compare::Kind>() {
        blocks.push(against(name, output));
        blocks.push(Block::List(vec![stabilisation(output), balance(output)]));
    }
    blocks
}

fn configuration(report: &PassReport<'_>) -> Block {
    let row = |measurement: &Measurement| {
        let rows = 0..measurement.len();
        let held_out = rows.clone().filter(|&row| measurement.held_out(row)).count();
        let ignored = rows.filter(|&row| measurement.ignored(row)).count();
        let kind = match &measurement.rows {
            Rows::Steady(_) => "steady phases",
            Rows::Transient { .. } => "instants of a transient",
        };
        let sensors: Vec<String> = (measurement.sensors.iter())
            .map(|sensor| {
                let quantity = report.model.quantities.get(sensor.quantity);
                let unit = Shown::si(quantity.map_or("", |own| own.unit.as_str()));
                let noise = sensor.total_sd();
                if noise > 0.0 { format!("{} (\u{B1} {})", sensor.name, unit.text(noise)) } else { sensor.name.clone() }
            })
            .collect();
        vec![
            Cell::code(&measurement.name),
            format!("{} {kind}, {held_out} held out, {ignored} left out", measurement.len()).into(),
            sensors.join(", ").into(),
            Cell::code(&measurement.file),
        ]
    };
    Block::Table(Table {
        caption: "Test configuration: phases, sensors with the standard deviation of their noise, file.".into(),
        columns: vec![Column::text("Measurement"), Column::text("Rows"), Column::text("Sensors"), Column::text("File")],
        rows: report.measurements.iter().map(row).collect(),
    })
}

fn against(name: &str, output: &compare::Output) -> Block {
    let text = |own: &Deviation| {
        if own.count == 0 { NONE.to_owned() } else { format!("{} (largest {})", fixed(own.rmse, 2), fixed(own.max, 2)) }
    };
    let tuned = |own: Option<&Deviation>| own.map_or_else(|| NONE.to_owned(), text);
    let rows = output.sensors.iter().map(|sensor| {
        let own = sensor.tuned.as_ref();
        vec![
            Cell::code(&sensor.measurement),
            Cell::code(&sensor.sensor),
            sensor.unit.clone().into(),
            text(&sensor.train).into(),
            tuned(own.map(|own| &own.train)).into(),
            text(&sensor.held_out).into(),
            tuned(own.map(|own| &own.held_out)).into(),
        ]
    });
    Block::Table(Table {
        caption: Text::new("Prediction against test before and after, job ")
            .code(name)
            .plain(": root mean square and largest magnitude of measured minus predicted."),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Sensor"),
            Column::text("Unit"),
            Column::number("Fitted, untuned", ""),
            Column::number("Fitted, tuned", ""),
            Column::number("Held out, untuned", ""),
            Column::number("Held out, tuned", ""),
        ],
        rows: rows.collect(),
    })
}

fn stabilisation(output: &compare::Output) -> Text {
    let judged = output.stabilisation.iter().filter_map(|own| own.stabilised);
    let (count, steady) = (judged.clone().count(), judged.filter(|own| *own).count());
    if count == 0 {
        return "Stabilisation: the file holds means of phases, no record of them in time; that they were steady is taken from \
                the test's own report."
            .into();
    }
    format!("Stabilisation: {steady} of {count} phases do not drift faster than the criteria allow.").into()
}

fn balance(output: &compare::Output) -> Text {
    let worst = output.heat.iter().map(|own| own.imbalance_w.abs()).fold(0.0, f64::max);
    let sources = output.heat.iter().map(|own| own.sources_w.abs()).fold(0.0, f64::max);
    if output.heat.is_empty() {
        return "Heat balance: not stated.".into();
    }
    format!(
        "Heat balance of the model: the largest imbalance of a phase is {} W, of sources up to {} W.",
        significant(worst, 2),
        significant(sources, 3)
    )
    .into()
}

/// Inputs of the environments against what was tested.
pub(super) fn domain(report: &PassReport<'_>) -> Option<Block> {
    let mut rows = Vec::new();
    for (position, input) in report.model.inputs.iter().enumerate() {
        let shown = Shown::written(&input.unit);
        let of = |measurement: &Measurement| -> Vec<f64> {
            let rows = (0..measurement.len()).filter(|&row| !measurement.ignored(row));
            rows.filter_map(|row| input_in_row(measurement, row, position)).filter(|value| value.is_finite()).collect()
        };
        let tested: Vec<f64> = report.measurements.iter().flat_map(of).collect();
        let low = tested.iter().copied().reduce(f64::min);
        let high = tested.iter().copied().reduce(f64::max);
        let Some((low, high)) = low.zip(high) else { continue };
        for environment in &report.environments {
            let Some(&value) = environment.inputs.get(position) else { continue };
            let is_inside = low <= value && value <= high;
            rows.push(vec![
                Cell::code(&input.name),
                format!("{} to {}", shown.number(low), shown.text(high)).into(),
                Cell::code(&environment.name),
                shown.text(value).into(),
                if is_inside {
                    Cell::marked("within", Status::Ok)
                } else {
                    Cell::marked("EXTRAPOLATION", Status::Caution)
                },
            ]);
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Inputs of the environments against those of the phases and instants that were tested.".into(),
            columns: vec![
                Column::text("Input"),
                Column::text("Tested"),
                Column::text("Environment"),
                Column::text("Value"),
                Column::text("Within the test"),
            ],
            rows,
        })
    })
}
