//! The measurements: files, sensors, what is missing, held out or left out and why.

use crate::document::time;
use crate::measurement::{Initial, Measurement, Rows, Sensor, Uncertain};
use crate::report::number::{NONE, Shown};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text};
use crate::report::view::PassReport;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on the data; not without measurements.
fn build(report: &PassReport<'_>) -> Option<Section> {
    if report.measurements.is_empty() {
        return None;
    }
    let mut blocks = Vec::new();
    for measurement in report.measurements {
        blocks.push(Block::Heading(measurement.name.clone()));
        blocks.push(overview(measurement));
        blocks.push(sensors(report, measurement));
        blocks.extend(left_out(measurement));
        if !measurement.unused_columns.is_empty() {
            let names = measurement.unused_columns.join(", ");
            blocks.push(Block::Paragraph(Text::new("Columns of the file that nothing uses: ").code(names).plain(".")));
        }
    }
    Some(Section { id: "data", title: "Measurements".into(), blocks })
}

fn overview(measurement: &Measurement) -> Block {
    let held_out = (0..measurement.len()).filter(|&row| measurement.held_out(row)).count();
    let ignored = (0..measurement.len()).filter(|&row| measurement.ignored(row)).count();
    let missing = measurement.readings.iter().filter(|r| r.is_none()).count();
    let (kind, rows) = match &measurement.rows {
        Rows::Steady(_) => ("steady phases".to_owned(), "Phases"),
        Rows::Transient { inputs, initial, .. } => {
            let span = match (inputs.times_s.first(), inputs.times_s.last()) {
                (Some(from), Some(to)) => format!(", {}", time::stretch(*from, *to, inputs.longest_s())),
                _ => String::new(),
            };
            let start = match initial {
                Initial::Temperatures { .. } => "given or fitted temperatures",
                Initial::Steady => "the steady state",
                Initial::Periodic => "the periodic state",
            };
            (format!("transient{span}, starting from {start}"), "Instants")
        }
    };
    let of_clocks = if has_clocks(measurement) {
        "; by a clock that is off, readings of instants outside the record count as missing"
    } else {
        ""
    };
    let missing_text = if missing == 0 {
        "none".to_owned()
    } else {
        format!("{missing} of {}; skipped, not filled in{of_clocks}", measurement.readings.len())
    };
    Block::Definitions(vec![
        ("File".into(), Text::default().code(&measurement.file)),
        ("SHA-256".into(), Text::default().code(&measurement.sha256)),
        ("Kind".into(), kind.into()),
        (rows.into(), format!("{} ({held_out} held out, {ignored} left out)", measurement.len()).into()),
        ("Missing readings".into(), missing_text.into()),
    ])
}

fn uncertain(value: Option<&Uncertain>, shown: &Shown) -> String {
    match value {
        None => NONE.to_owned(),
        Some(Uncertain::Known(value)) => shown.text(*value),
        Some(Uncertain::Inferred(_) | Uncertain::InferredFrom { .. } | Uncertain::Parameter { .. }) => {
            "inferred".to_owned()
        }
    }
}

fn seconds(value: Option<&Uncertain>) -> String {
    let known = if let Some(Uncertain::Known(known)) = value { *known } else { 0.0 };
    uncertain(value, &Shown::time(known))
}

fn sensors(report: &PassReport<'_>, measurement: &Measurement) -> Block {
    let rows = measurement
        .sensors
        .iter()
        .enumerate()
        .map(|(position, sensor)| sensor_row(report, measurement, position, sensor))
        .collect();
    let mut columns = vec![
        Column::text("Sensor"),
        Column::text("Measures"),
        Column::text("Unit in the file"),
        Column::number("Noise, standard deviation", ""),
        Column::number("Bias", ""),
        Column::number("Time constant", ""),
        Column::number("Noise correlation time", ""),
        Column::number("Missing", ""),
    ];
    if has_clocks(measurement) {
        columns.push(Column::number("Clock behind by", ""));
    }
    Block::Table(Table { caption: Text::new("Sensors of ").code(&measurement.name).plain("."), columns, rows })
}

/// By how much the clock of a sensor is behind.
fn behind(sensor: &Sensor) -> String {
    let inferred = sensor.behind_s.iter().find(|value| !matches!(value, Uncertain::Known(_)));
    let known = Uncertain::Known(sensor.timing(&[]).behind_s);
    seconds(inferred.or((!sensor.behind_s.is_empty()).then_some(&known)))
}

/// Whether the clock of some sensor is said to be off.
fn has_clocks(measurement: &Measurement) -> bool {
    measurement.sensors.iter().any(|sensor| !sensor.behind_s.is_empty())
}

fn sensor_row(report: &PassReport<'_>, measurement: &Measurement, position: usize, sensor: &Sensor) -> Vec<Cell> {
    let quantity = report.model.quantities.get(sensor.quantity);
    let unit = quantity.map_or("", |q| q.unit.as_str());
    let shown = Shown::si(unit);
    let missing = measurement
        .readings
        .iter()
        .skip(position)
        .step_by(measurement.sensors.len().max(1))
        .filter(|r| r.is_none())
        .count();
    let mut cells = vec![
        Cell::code(&sensor.name),
        Cell::code(quantity.map_or(NONE, |q| q.name.as_str())),
        crate::report::number::typeset(&sensor.unit).into(),
        uncertain(sensor.sigma.as_ref(), &shown).into(),
        uncertain(sensor.bias.as_ref(), &shown).into(),
        seconds(sensor.lag_s.as_ref()).into(),
        seconds(sensor.correlation_time_s.as_ref()).into(),
        if missing == 0 { Cell::from("0") } else { Cell::marked(missing.to_string(), Status::Caution) },
    ];
    if has_clocks(measurement) {
        cells.push(behind(sensor).into());
    }
    cells
}

/// Phases, or runs of instants with the same reason, that are left out.
fn left_out(measurement: &Measurement) -> Option<Block> {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    match &measurement.rows {
        Rows::Steady(phases) => {
            for phase in phases {
                if let Some(reason) = &phase.ignored {
                    rows.push(vec![Cell::code(&phase.name), Cell::from(reason.clone())]);
                }
            }
        }
        Rows::Transient { inputs, ignored, .. } => {
            let mut run: Option<(f64, f64, &String)> = None;
            let mut close = |run: Option<(f64, f64, &String)>| {
                if let Some((from, to, reason)) = run {
                    let stretch = time::stretch(from, to, inputs.longest_s());
                    rows.push(vec![Cell::from(stretch), Cell::from(reason.clone())]);
                }
            };
            for (&time, reason) in inputs.times_s.iter().zip(ignored) {
                run = match (run, reason) {
                    (Some((from, _, current)), Some(reason)) if current == reason => Some((from, time, current)),
                    (earlier, Some(reason)) => {
                        close(earlier);
                        Some((time, time, reason))
                    }
                    (earlier, None) => {
                        close(earlier);
                        None
                    }
                };
            }
            close(run);
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Left out of every fit and every statistic.".into(),
            columns: vec![Column::text("What"), Column::text("Because")],
            rows,
        })
    })
}
