//! Model against measurements: criteria, sensors, phases, residuals in time, trends, heat balance, steadiness.

use crate::job::compare::{Deviation, Output, Row, SensorSummary};
use crate::report::number::{NONE, Shown, fixed, percent, signed, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{
    Axis, Chart, HeatMap, History, Layer, Limit, Shade, Strip, heat_map, history, palette, residual_strips,
};
use crate::report::view::PassReport;

/// Readings up to which the table of all of them is part of the report.
const MOST_ROWS: usize = 300;

/// The section on the comparison; not without such a job.
pub fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.comparisons().count();
    for (name, output) in report.comparisons() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        blocks.push(Block::Paragraph(
            Text::new("Parameters: ")
                .strong(if output.state == "nominal" {
                    "nominal, the model as delivered".to_owned()
                } else {
                    output.state.clone()
                })
                .plain(". Deviations are measured minus predicted: positive where the model is too low."),
        ));
        blocks.extend(where_it_fails(output));
        blocks.extend(criteria(output));
        blocks.push(sensors(output));
        blocks.extend(figures(report, name, output));
        blocks.extend(phases(output));
        blocks.extend(trends(output));
        blocks.extend(heat(output));
        blocks.extend(stabilisation(output));
        blocks.extend(readings(report, output));
    }
    (!blocks.is_empty()).then(|| Section { id: "comparison", title: "Model against measurements".into(), blocks })
}

fn where_it_fails(output: &Output) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !output.failed.is_empty() {
        let rows = output
            .failed
            .iter()
            .map(|f| vec![Cell::code(&f.measurement), Cell::code(&f.phase), f.reason.clone().into()])
            .collect();
        blocks.push(Block::callout(Tone::Warning, "Some phases have no prediction; they are in no statistic below."));
        blocks.push(Block::Table(Table {
            caption: "Phases without a prediction.".into(),
            columns: vec![Column::text("Measurement"), Column::text("Phase"), Column::text("Reason")],
            rows,
        }));
    }
    if output.fails.is_empty() {
        blocks.push(Block::callout(Tone::Verdict, "The comparison finds no place where the model fails."));
    } else {
        blocks.push(Block::paragraph("Where the model fails, worst first:"));
        blocks.push(Block::List(output.fails.iter().map(|f| Text::new(f.clone())).collect()));
    }
    blocks
}

fn criteria(output: &Output) -> Option<Block> {
    if output.verdicts.is_empty() {
        return None;
    }
    let rows = output
        .verdicts
        .iter()
        .map(|v| {
            vec![
                v.criterion.clone().into(),
                significant(v.value, 3).into(),
                significant(v.limit, 3).into(),
                Cell::marked(if v.kept { "kept" } else { "not kept" }, Status::kept(v.kept)),
            ]
        })
        .collect();
    Some(Block::Table(Table {
        caption: Text::new("Criteria of profile ")
            .strong(output.criteria.title.clone())
            .plain(format!(". Source: {}", output.criteria.source)),
        columns: vec![
            Column::text("Criterion"),
            Column::number("Value", ""),
            Column::number("Limit", ""),
            Column::text("Outcome"),
        ],
        rows,
    }))
}

fn decimals(unit: &str) -> usize {
    if unit == "K" { 2 } else { 4 }
}

/// How a sensor's RMSE stands against what its noise alone would give.
pub(super) fn against_noise(sensor: &SensorSummary, deviation: &Deviation) -> Option<Status> {
    let [low, high] = sensor.noise_rmse?;
    (deviation.count > 0).then_some(if deviation.rmse > high {
        Status::Fail
    } else if deviation.rmse < low {
        Status::Caution
    } else {
        Status::Ok
    })
}

fn sensors(output: &Output) -> Block {
    let has_held_out = output.sensors.iter().any(|s| s.held_out.count > 0);
    let mut rows = Vec::new();
    for sensor in &output.sensors {
        let digits = decimals(&sensor.unit);
        for (name, deviation) in [("for fits", &sensor.train), ("held out", &sensor.held_out)] {
            if deviation.count == 0 {
                continue;
            }
            let mut row = vec![Cell::code(&sensor.measurement), Cell::code(&sensor.sensor)];
            if has_held_out {
                row.push(name.into());
            }
            let rmse = fixed(deviation.rmse, digits);
            row.extend([
                Cell::from(deviation.count.to_string()),
                signed(deviation.mean, digits).into(),
                fixed(deviation.sd, digits).into(),
                Cell { text: rmse.into(), status: against_noise(sensor, deviation) },
                sensor
                    .noise_rmse
                    .map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", fixed(a, digits), fixed(b, digits)))
                    .into(),
                fixed(deviation.max, digits).into(),
                percent(deviation.within_limit, 0).into(),
                crate::report::number::typeset(&sensor.unit).into(),
            ]);
            rows.push(row);
        }
    }
    let mut columns = vec![Column::text("Measurement"), Column::text("Sensor")];
    if has_held_out {
        columns.push(Column::text("Readings"));
    }
    columns.extend(
        ["Number", "Mean", "Standard deviation", "RMSE", "RMSE of noise alone", "Largest", "Within limit"]
            .map(|t| Column::number(t, "")),
    );
    columns.push(Column::text("Unit"));
    Block::Table(Table {
        caption: "Deviations by sensor. The RMSE is red above the 95 % range that the sensor's noise alone would give, green within it.".into(),
        columns,
        rows,
    })
}

/// Measurements of an output in the order of the rows.
fn measurements(output: &Output) -> Vec<&str> {
    let mut out: Vec<&str> = Vec::new();
    for row in &output.rows {
        if !out.contains(&row.measurement.as_str()) {
            out.push(&row.measurement);
        }
    }
    out
}

fn sensor_names<'a>(output: &'a Output, measurement: &str) -> Vec<(&'a str, &'a str)> {
    let mut out: Vec<(&str, &str)> = Vec::new();
    for row in output.rows.iter().filter(|r| r.measurement == measurement) {
        if !out.iter().any(|known| known.0 == row.sensor) {
            out.push((&row.sensor, &row.unit));
        }
    }
    out
}

/// All figures of a comparison but the one that stands in the summary.
fn figures(report: &PassReport<'_>, job: &str, output: &Output) -> Vec<Block> {
    let main = super::summary::main_picture(report).map(|f| f.id);
    let mut open = Vec::new();
    let mut folded = Vec::new();
    for measurement in measurements(output) {
        if report.is_steady(measurement, &output.rows) {
            open.push(phase_map(job, output, measurement));
        } else {
            open.push(strips(job, output, measurement));
            folded.extend(
                sensor_names(output, measurement)
                    .into_iter()
                    .map(|(sensor, _)| time_history(report, job, output, measurement, sensor)),
            );
        }
        folded.extend(residual_histogram(job, output, measurement));
    }
    let keep = |figures: Vec<Figure>| -> Vec<Block> {
        figures.into_iter().filter(|f| main.as_ref() != Some(&f.id)).map(Block::Figure).collect()
    };
    let mut blocks = keep(open);
    let folded = keep(folded);
    if !folded.is_empty() {
        blocks.push(Block::Details(format!("Further plots ({})", folded.len()), folded));
    }
    blocks
}

/// Deviations by phase and sensor.
pub(super) fn phase_map(job: &str, output: &Output, measurement: &str) -> Figure {
    let sensors = sensor_names(output, measurement);
    let rows: Vec<&Row> = output.rows.iter().filter(|r| r.measurement == measurement).collect();
    let mut phases: Vec<(&str, bool)> = Vec::new();
    for row in &rows {
        let name = row.phase.as_deref().unwrap_or(NONE);
        if phases.last().is_none_or(|last| last.0 != name) && !phases.iter().any(|p| p.0 == name) {
            phases.push((name, row.held_out));
        }
    }
    let value = |phase: &str, sensor: &str| {
        rows.iter()
            .find(|r| r.phase.as_deref().unwrap_or(NONE) == phase && r.sensor == sensor)
            .map(|r| r.measured - r.predicted)
    };
    let units: Vec<&str> = sensors.iter().map(|s| s.1).collect();
    let unit = if units.iter().all(|u| *u == "K") { "K" } else { "SI" };
    let map = HeatMap {
        columns: sensors.iter().map(|s| s.0.to_owned()).collect(),
        rows: phases
            .iter()
            .map(|&(phase, held_out)| (phase.to_owned(), held_out, sensors.iter().map(|s| value(phase, s.0)).collect()))
            .collect(),
        full_scale: 0.0,
        legend: format!("measured \u{2212} predicted [{unit}]: blue = model too high, orange = model too low"),
        mark_label: "held out from every fit".into(),
        decimals: decimals(unit),
    };
    Figure {
        id: format!("{job}-{measurement}-phases"),
        drawing: heat_map(&map),
        caption: Text::new("Measured minus predicted by phase and sensor, ").code(measurement).plain("."),
        alternative: format!(
            "Heat map of measured minus predicted in {unit} for {} phases and {} sensors of {measurement}. {}",
            phases.len(),
            sensors.len(),
            output.fails.first().map_or("", String::as_str)
        ),
    }
}

/// Stretches of time that are held out, from the rows.
fn held_out(rows: &[&Row]) -> Vec<Shade> {
    let mut times: Vec<(f64, bool)> = rows.iter().filter_map(|r| Some((r.time_s?, r.held_out))).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut out: Vec<Shade> = Vec::new();
    let mut is_open = false;
    for (time, held) in times {
        match (held, is_open, out.last_mut()) {
            (true, true, Some(shade)) => shade.to = time,
            (true, ..) => out.push(Shade { from: time, to: time }),
            _ => {}
        }
        is_open = held;
    }
    out
}

fn of_sensor<'a>(output: &'a Output, measurement: &str, sensor: &str) -> Vec<&'a Row> {
    output.rows.iter().filter(|r| r.measurement == measurement && r.sensor == sensor && r.time_s.is_some()).collect()
}

/// Time in the unit that keeps its numbers short.
fn time_unit(rows: &[&Row]) -> (f64, &'static str) {
    let last = rows.iter().filter_map(|r| r.time_s).fold(0.0, f64::max);
    if last > 48.0 * 3600.0 {
        (86_400.0, "time [d]")
    } else if last > 3.0 * 3600.0 {
        (3600.0, "time [h]")
    } else {
        (1.0, "time [s]")
    }
}

fn scaled(mut shades: Vec<Shade>, unit: f64) -> Vec<Shade> {
    for shade in &mut shades {
        shade.from /= unit;
        shade.to /= unit;
    }
    shades
}

fn strips(job: &str, output: &Output, measurement: &str) -> Figure {
    let sensors = sensor_names(output, measurement);
    let all: Vec<&Row> = output.rows.iter().filter(|r| r.measurement == measurement).collect();
    let (per, title) = time_unit(&all);
    let strips: Vec<Strip> = sensors
        .iter()
        .map(|(sensor, _)| Strip {
            label: (*sensor).to_owned(),
            points: of_sensor(output, measurement, sensor)
                .into_iter()
                .map(|r| (r.time_s.unwrap_or(f64::NAN) / per, r.measured - r.predicted))
                .collect(),
        })
        .collect();
    let unit = if sensors.iter().all(|s| s.1 == "K") { "K" } else { "SI" };
    let shades = scaled(held_out(&all), per);
    let shaded = if shades.is_empty() { "" } else { "; the shaded time is held out from every fit" };
    Figure {
        id: format!("{job}-{measurement}-residuals"),
        drawing: residual_strips(title, &format!("dev. [{unit}]"), &strips, &shades),
        caption: Text::new("Measured minus predicted over time, ").code(measurement).plain(format!("{shaded}.")),
        alternative: format!(
            "Residuals over time, one strip for each of {} sensors of {measurement}{shaded}.",
            sensors.len()
        ),
    }
}

/// Measured and predicted over time for one sensor.
pub(super) fn time_history(
    report: &PassReport<'_>,
    job: &str,
    output: &Output,
    measurement: &str,
    sensor: &str,
) -> Figure {
    let rows = of_sensor(output, measurement, sensor);
    let unit = rows.first().map_or("", |r| r.unit.as_str());
    let shown = report.sensor_shown(measurement, sensor, unit);
    let (per, title) = time_unit(&rows);
    let shades = scaled(held_out(&rows), per);
    let shaded = if shades.is_empty() { "" } else { " The shaded time is held out from every fit." };
    let data = History {
        x_title: title.into(),
        y_title: shown.title(sensor),
        residual_title: shown.difference().title("meas. \u{2212} pred."),
        points: rows
            .iter()
            .map(|r| (r.time_s.unwrap_or(f64::NAN) / per, shown.value(r.measured), shown.value(r.predicted)))
            .collect(),
        held_out: shades,
        limit: output.criteria.each_k.filter(|_| unit == "K"),
    };
    let summary = output.sensors.iter().find(|s| s.measurement == measurement && s.sensor == sensor);
    let rmse = summary.map_or(String::new(), |s| {
        let mut text = format!(" RMSE {}", shown.difference().text(s.train.rmse));
        if s.held_out.count > 0 {
            text += &format!(", held out {}", shown.difference().text(s.held_out.rmse));
        }
        text + "."
    });
    Figure {
        id: format!("{job}-{measurement}-{sensor}-history"),
        drawing: history(&data),
        caption: Text::new("Measured and predicted over time, sensor ").code(sensor).plain(format!(
            ".{rmse}{shaded}{}",
            if data.limit.is_some() { " Dashed: the criterion for one reading." } else { "" }
        )),
        alternative: format!("Measured and predicted {sensor} over time, with the residual below.{rmse}{shaded}"),
    }
}

fn residual_histogram(job: &str, output: &Output, measurement: &str) -> Option<Figure> {
    let residuals: Vec<f64> = output
        .rows
        .iter()
        .filter(|r| r.measurement == measurement && r.unit == "K")
        .map(|r| r.measured - r.predicted)
        .filter(|d| d.is_finite())
        .collect();
    let largest = residuals.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
    if residuals.len() < 8 || largest == 0.0 {
        return None;
    }
    let bins = if residuals.len() < 60 { 13 } else { 31 };
    let width = 2.0 * largest / bins as f64;
    let edges: Vec<f64> = (0..=bins).map(|i| -largest + width * i as f64).collect();
    let mut counts = vec![0.0; bins];
    for d in &residuals {
        counts[(((d + largest) / width) as usize).min(bins - 1)] += 1.0;
    }
    let mut limits =
        vec![Limit { along: crate::report::plot::Along::X, value: 0.0, label: String::new(), colour: palette::INK }];
    if let Some(limit) = output.criteria.each_k.filter(|l| *l <= largest) {
        limits.extend([-limit, limit].map(|value| Limit {
            along: crate::report::plot::Along::X,
            value,
            label: format!("{} K", signed(value, 1)),
            colour: palette::VERMILION,
        }));
    }
    let chart = Chart {
        x: Axis::new("measured \u{2212} predicted [K]"),
        y: Axis::new("readings"),
        layers: vec![Layer::Bars { edges, heights: counts, colour: palette::BLUE, label: String::new() }],
        limits,
        height: 700,
        ..Chart::default()
    };
    let caption = format!("All deviations of {measurement}, {} readings.", residuals.len());
    Some(Figure {
        id: format!("{job}-{measurement}-deviations"),
        drawing: chart.draw(),
        alternative: format!("Histogram. {caption}"),
        caption: caption.into(),
    })
}

fn phases(output: &Output) -> Option<Block> {
    if output.phases.is_empty() {
        return None;
    }
    let rows = output
        .phases
        .iter()
        .map(|p| {
            vec![
                Cell::code(&p.measurement),
                Cell::code(&p.phase),
                (if p.held_out { "held out" } else { "for fits" }).into(),
                signed(p.deviation.mean, 2).into(),
                fixed(p.deviation.sd, 2).into(),
                fixed(p.deviation.rmse, 2).into(),
                Cell::code(&p.worst_sensor),
                signed(p.worst, 2).into(),
            ]
        })
        .collect();
    let table = Block::Table(Table {
        caption: "Deviations by phase or stretch of time, over all sensors, K.".into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Phase"),
            Column::text("Readings"),
            Column::number("Mean", ""),
            Column::number("Standard deviation", ""),
            Column::number("RMSE", ""),
            Column::text("Worst sensor"),
            Column::number("Its deviation", ""),
        ],
        rows,
    });
    Some(if output.phases.len() > 12 {
        Block::Details(format!("Table of the phases ({})", output.phases.len()), vec![table])
    } else {
        table
    })
}

fn trends(output: &Output) -> Option<Block> {
    if output.trends.is_empty() {
        return None;
    }
    let rows = output
        .trends
        .iter()
        .take(12)
        .map(|t| {
            let is_clear = t.slope_error > 0.0 && t.slope.abs() > 3.0 * t.slope_error;
            vec![
                Cell::code(&t.measurement),
                Cell::code(&t.sensor),
                Cell::code(&t.against),
                signed(t.change, 2).into(),
                format!("{} \u{00B1} {}", significant(t.slope, 3), significant(t.slope_error, 2)).into(),
                crate::report::number::typeset(&t.unit).into(),
                Cell { text: fixed(t.correlation, 2).into(), status: is_clear.then_some(Status::Caution) },
            ]
        })
        .collect();
    Some(Block::Table(Table {
        caption: "What the deviations go with, strongest first; marked where the slope is more than three standard errors from zero. \
                  A deviation that follows an input points at the physics of that input."
            .into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Sensor"),
            Column::text("Against"),
            Column::number("Change over its range", "K"),
            Column::number("Slope, SI per unit", ""),
            Column::text("Unit"),
            Column::number("Correlation", ""),
        ],
        rows,
    }))
}

fn heat(output: &Output) -> Option<Block> {
    if output.heat.is_empty() {
        return None;
    }
    let mut boundaries: Vec<&str> = Vec::new();
    for (name, _) in output.heat.iter().flat_map(|h| &h.into_boundaries_w) {
        if !boundaries.contains(&name.as_str()) {
            boundaries.push(name);
        }
    }
    let mut columns = vec![Column::text("Measurement"), Column::text("Phase"), Column::number("Sources", "W")];
    columns.extend(boundaries.iter().map(|b| Column::number(format!("into {b}"), "W")));
    columns.extend([Column::number("Stored", "W"), Column::number("Imbalance", "W")]);
    let watts = |w: f64| Cell::from(if w.abs() < 5e-7 { "0".to_owned() } else { significant(w, 3) });
    let rows = output
        .heat
        .iter()
        .map(|h| {
            let mut row = vec![Cell::code(&h.measurement), Cell::code(&h.phase), watts(h.sources_w)];
            row.extend(boundaries.iter().map(|b| {
                h.into_boundaries_w
                    .iter()
                    .find(|(name, _)| name == b)
                    .map_or_else(|| Cell::from(NONE), |(_, w)| watts(*w))
            }));
            row.extend([watts(h.stored_w), watts(h.imbalance_w)]);
            row
        })
        .collect();
    let table = Block::Table(Table { caption: "Heat balance of the model.".into(), columns, rows });
    Some(if output.heat.len() > 12 {
        Block::Details(format!("Heat balance ({} phases)", output.heat.len()), vec![table])
    } else {
        table
    })
}

fn stabilisation(output: &Output) -> Option<Block> {
    if output.stabilisation.is_empty() {
        return None;
    }
    let rows = output
        .stabilisation
        .iter()
        .map(|s| {
            let per_hour = |v: f64| significant(3600.0 * v, 3);
            vec![
                Cell::code(&s.measurement),
                Cell::code(&s.phase),
                Cell::code(&s.sensor),
                format!("{} \u{00B1} {}", per_hour(s.drift_k_per_s), per_hour(s.drift_error_k_per_s)).into(),
                significant(s.stored_w, 3).into(),
                s.stabilised.map_or_else(
                    || Cell::from(NONE),
                    |kept| Cell::marked(if kept { "steady" } else { "drifts" }, Status::kept(kept)),
                ),
            ]
        })
        .collect();
    Some(Block::Table(Table {
        caption: "Steadiness of the phases: the fastest drift, and the heat that it hides.".into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Phase"),
            Column::text("Sensor"),
            Column::number("Drift", "K/h"),
            Column::number("Heat stored", "W"),
            Column::text("Outcome"),
        ],
        rows,
    }))
}

fn readings(report: &PassReport<'_>, output: &Output) -> Option<Block> {
    if output.rows.is_empty() {
        return None;
    }
    if output.rows.len() > MOST_ROWS {
        return Some(Block::Paragraph(
            Text::new(format!("All {} readings beside their predictions are in ", output.rows.len()))
                .code("results.json")
                .plain("."),
        ));
    }
    let rows = output
        .rows
        .iter()
        .map(|r| {
            let shown: Shown = report.sensor_shown(&r.measurement, &r.sensor, &r.unit);
            let moment = match (&r.phase, r.time_s) {
                (Some(phase), _) => Cell::code(phase),
                (None, Some(time)) => format!("{} s", fixed(time, 1)).into(),
                (None, None) => NONE.into(),
            };
            vec![
                Cell::code(&r.measurement),
                moment,
                Cell::code(&r.sensor),
                shown.number(r.measured).into(),
                shown.number(r.predicted).into(),
                signed(r.measured - r.predicted, decimals(&r.unit)).into(),
                shown.unit.clone().into(),
                (if r.held_out { "held out" } else { "" }).into(),
            ]
        })
        .collect();
    let table = Block::Table(Table {
        caption: "Readings beside predictions.".into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Phase or time"),
            Column::text("Sensor"),
            Column::number("Measured", ""),
            Column::number("Predicted", ""),
            Column::number("Deviation", ""),
            Column::text("Unit"),
            Column::text(""),
        ],
        rows,
    });
    Some(Block::Details(format!("All readings ({})", output.rows.len()), vec![table]))
}
