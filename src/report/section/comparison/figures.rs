//! Figures of a comparison: map of the phases, residuals and histories in time, histogram of the deviations.

use std::collections::HashMap;

use crate::document::counted;
use crate::document::time::unit_of_time;
use crate::job::compare::{Kind, Output, Row, SensorSummary, Table};
use crate::math::sort::sort_by;
use crate::report::number::{NONE, signed};
use crate::report::page::{Block, Figure, Text};
use crate::report::plot::{
    Along, Axis, Chart, HeatMap, History, Layer, Limit, Shade, Strip, heat_map, history, palette, residual_strips,
};
use crate::report::view::PassReport;
use crate::study::resolve::belongs_to;

use super::super::prefix;
use super::{MOST_SENSORS, WORST_SENSORS, worst_first};

/// Most histories of single sensors in a comparison; of more, each measurement keeps those of its worst sensors.
const MOST_HISTORIES: usize = 24;

/// Measurements of an output in the order of the rows.
fn measurements(output: &Output) -> Vec<&str> {
    let mut out: Vec<&str> = Vec::new();
    for table in output.rows.tables() {
        if !out.contains(&table.measurement.as_str()) {
            out.push(&table.measurement);
        }
    }
    out
}

/// The measurements that are parts of one record, in the order of the rows: a transient goes on after a gap as another one.
fn parts<'a>(report: &PassReport<'_>, output: &'a Output, measurement: &str) -> Vec<&'a str> {
    let file = |name: &str| report.measurements.iter().find(|own| own.name == name).map(|own| &own.sha256);
    let all = measurements(output);
    let is_whole = |name: &&str| belongs_to(measurement, name) && file(name) == file(measurement);
    let whole = all.iter().copied().find(is_whole).unwrap_or(measurement);
    all.iter().copied().filter(|name| belongs_to(name, whole) && file(name) == file(whole)).collect()
}

/// Sensors of a measurement with their units; the worst where there are many.
fn sensor_names<'a>(output: &'a Output, measurement: &str) -> Vec<(&'a str, &'a str)> {
    let mut out: Vec<(&str, &str)> = Vec::new();
    for table in output.rows.of_measurement(measurement) {
        for channel in table.channels_read() {
            if !out.iter().any(|listed_sensor| listed_sensor.0 == channel.sensor) {
                out.push((&channel.sensor, &channel.unit));
            }
        }
    }
    if out.len() > MOST_SENSORS {
        keep_worst(output, measurement, WORST_SENSORS, &mut out);
    }
    out
}

/// Keeps so many sensors of a measurement, those with the largest errors, in their order.
fn keep_worst(output: &Output, measurement: &str, most: usize, names: &mut Vec<(&str, &str)>) {
    let of_measurement = output.sensors.iter().filter(|sensor| sensor.measurement == measurement);
    let mut sensors: Vec<&SensorSummary> = of_measurement.collect();
    worst_first(&mut sensors);
    sensors.truncate(most);
    names.retain(|(name, _)| sensors.iter().any(|sensor| sensor.sensor == *name));
}

/// The states of the model that a comparison knows, as delivered first.
fn states(output: &Output) -> impl Iterator<Item = Shows> {
    [Some(Shows::Delivered), output.tuned.is_some().then_some(Shows::Tuned)].into_iter().flatten()
}

/// All figures of a comparison: as delivered, and where it was tuned the map after it.
pub(super) fn figures(report: &PassReport<'_>, job: &str, output: &Output) -> Vec<Block> {
    let mut open = Vec::new();
    let mut folded = Vec::new();
    let of_time = |measurement: &&str| !report.is_steady(measurement, &output.rows);
    let transients: Vec<&str> = measurements(output).into_iter().filter(of_time).collect();
    let histories: usize = transients.iter().map(|measurement| sensor_names(output, measurement).len()).sum();
    let most = if histories > MOST_HISTORIES { (MOST_HISTORIES / transients.len()).max(1) } else { histories };
    for measurement in measurements(output) {
        let is_first_part = parts(report, output, measurement).first().is_none_or(|first| *first == measurement);
        if report.is_steady(measurement, &output.rows) {
            open.extend(states(output).map(|shows| phase_map(report, job, output, measurement, shows, false)));
        } else {
            open.push(strips(job, output, measurement));
            let mut names = sensor_names(output, measurement);
            keep_worst(output, measurement, most, &mut names);
            let history = |sensor: &str, shows| time_history(report, job, output, measurement, sensor, shows, false);
            // Histories show all parts of a record at once.
            if is_first_part {
                let own = parts(report, output, measurement);
                let worst = super::worst_sensor(output).filter(|worst| own.contains(&worst.measurement.as_str()));
                let tuned = worst.filter(|_| output.tuned.is_some());
                open.extend(tuned.map(|worst| history(worst.sensor.as_str(), Shows::Tuned)));
                folded.extend(names.into_iter().map(|(sensor, _)| history(sensor, Shows::Delivered)));
            }
        }
        folded.extend(residual_histogram(job, output, measurement));
    }
    let blocks_of = |figures: Vec<Figure>| -> Vec<Block> { figures.into_iter().map(Block::Figure).collect() };
    let (mut blocks, folded) = (blocks_of(open), blocks_of(folded));
    if !folded.is_empty() {
        let which = if most < histories { "; histories of the worst sensors" } else { "" };
        blocks.push(Block::Details(format!("Further plots ({}{which})", folded.len()), folded));
    }
    blocks
}

/// Which state of the model a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::report::section) enum Shows {
    /// That of the comparison.
    Delivered,
    /// After tuning.
    Tuned,
}

impl Shows {
    /// The state that counts: the tuned one where there is one.
    pub(in crate::report::section) fn of(output: &Output) -> Self {
        if output.tuned.is_some() { Self::Tuned } else { Self::Delivered }
    }

    pub(super) fn predicted(self, row: &Row<&str>) -> f64 {
        match self {
            Self::Delivered => row.predicted,
            Self::Tuned => row.predicted_tuned.unwrap_or(f64::NAN),
        }
    }

    fn id(self) -> &'static str {
        if self == Self::Tuned { "-tuned" } else { "" }
    }

    pub(super) fn words(self, report: &PassReport<'_>, output: &Output) -> &'static str {
        match (self, &output.tuned) {
            (Self::Tuned, _) => " after tuning",
            (Self::Delivered, Some(_)) if !report.adopted.is_empty() => " before tuning",
            (Self::Delivered, Some(_)) => " as delivered",
            (Self::Delivered, None) => "",
        }
    }
}

/// Magnitude of the full colour, K: the largest deviation that any state of the model leaves, so that maps before and after
/// tuning can be held against one another.
pub(super) fn full_scale(report: &PassReport<'_>) -> f64 {
    let rows = report.outputs::<Kind>().flat_map(|(_, output)| output.rows.iter()).filter(|row| row.unit == "K");
    let deviations = rows.flat_map(|row| {
        [Some(row.predicted), row.predicted_tuned]
            .into_iter()
            .flatten()
            .map(move |predicted| (row.measured - predicted).abs())
    });
    deviations.filter(|deviation| deviation.is_finite()).fold(0.0, f64::max)
}

/// Most phases and sensors of the map on the first screen.
const MOST_ON_FIRST_SCREEN: [usize; 2] = [9, 8];

/// Deviations by phase and sensor; on the first screen the largest of them.
pub(in crate::report::section) fn phase_map(
    report: &PassReport<'_>,
    job: &str,
    output: &Output,
    measurement: &str,
    shows: Shows,
    is_small: bool,
) -> Figure {
    let mut sensors = sensor_names(output, measurement);
    // Kelvins and other units have no colour in common; the table by sensor has them all.
    if sensors.iter().any(|sensor| sensor.1 == "K") {
        sensors.retain(|sensor| sensor.1 == "K");
    }
    let all_sensors = sensors.len();
    let [most_phases, most_sensors] = MOST_ON_FIRST_SCREEN;
    if is_small && all_sensors > most_sensors {
        keep_worst(output, measurement, most_sensors, &mut sensors);
    }
    let mut phases: Vec<(&str, bool)> = Vec::new();
    let mut deviations: HashMap<(&str, &str), f64> = HashMap::new();
    for row in output.rows.of_measurement(measurement).flat_map(Table::iter) {
        let name = row.phase.unwrap_or(NONE);
        if phases.last().is_none_or(|last| last.0 != name) && !phases.iter().any(|p| p.0 == name) {
            phases.push((name, row.held_out));
        }
        deviations.entry((name, row.sensor)).or_insert_with(|| row.measured - shows.predicted(&row));
    }
    let value =
        |phase: &str, sensor: &str| deviations.get(&(phase, sensor)).copied().filter(|deviation| deviation.is_finite());
    let all_phases = phases.len();
    if is_small && all_phases > most_phases {
        let worst_of = |phase: &str| {
            let deviations = sensors.iter().filter_map(|s| value(phase, s.0));
            deviations.map(f64::abs).fold(0.0, f64::max)
        };
        let mut ranked: Vec<(f64, &str)> = phases.iter().map(|&(phase, _)| (worst_of(phase), phase)).collect();
        sort_by(&mut ranked, |a, b| b.0.total_cmp(&a.0));
        ranked.truncate(most_phases);
        phases.retain(|(phase, _)| ranked.iter().any(|(_, kept)| kept == phase));
    }
    let units: Vec<&str> = sensors.iter().map(|s| s.1).collect();
    let unit = if units.iter().all(|u| *u == "K") { "K" } else { "SI" };
    let map = HeatMap {
        columns: sensors.iter().map(|s| s.0.to_owned()).collect(),
        rows: phases
            .iter()
            .map(|&(phase, held_out)| (phase.to_owned(), held_out, sensors.iter().map(|s| value(phase, s.0)).collect()))
            .collect(),
        full_scale: if unit == "K" { full_scale(report) } else { 0.0 },
        limit: output.criteria.each_k.filter(|_| unit == "K"),
        legend: if is_small {
            format!("meas. \u{2212} pred. [{unit}]: blue = model too high, orange = too low")
        } else {
            format!("measured \u{2212} predicted [{unit}]: blue = model too high, orange = model too low")
        },
        mark_label: if is_small { "held out" } else { "held out from every fit" }.into(),
        decimals: super::decimals(unit),
        is_unsigned: false,
        is_small,
    };
    let of = |kept: usize, all: usize, what: &str| (kept < all).then(|| format!("the worst {kept} of {all} {what}"));
    let cut: Vec<String> = [of(phases.len(), all_phases, "phases"), of(sensors.len(), all_sensors, "sensors")]
        .into_iter()
        .flatten()
        .filter(|_| is_small)
        .collect();
    let cut = if cut.is_empty() { ".".to_owned() } else { format!(": {}.", cut.join(", ")) };
    Figure {
        id: format!("{}{job}-{measurement}-phases{}", prefix(is_small), shows.id()),
        drawing: heat_map(&map),
        caption: Text::new(format!("Measured minus predicted{} by phase and sensor, ", shows.words(report, output)))
            .code(measurement)
            .plain(cut),
        alternative: format!(
            "Heat map of measured minus predicted{} in {unit} for {} and {} of {measurement}. {}",
            shows.words(report, output),
            counted(phases.len(), "phase"),
            counted(sensors.len(), "sensor"),
            output.fails.first().filter(|_| shows == Shows::Delivered).map_or("", String::as_str)
        ),
    }
}

/// Stretches of time that are held out, from instants of which each says whether it is.
fn held_out(mut times: Vec<(f64, bool)>) -> Vec<Shade> {
    sort_by(&mut times, |a, b| a.0.total_cmp(&b.0));
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

fn of_sensor<'a>(output: &'a Output, measurement: &str, sensor: &str) -> Vec<Row<&'a str>> {
    let rows = output.rows.of_measurement(measurement).flat_map(|table| table.of(sensor));
    rows.filter(|row| row.time_s.is_some()).collect()
}

/// Time in the unit that keeps its numbers short, and the title of its axis.
fn time_axis(times: &[(f64, bool)]) -> (f64, String) {
    let (per, unit) = unit_of_time(times.iter().map(|(time_s, _)| *time_s).fold(0.0, f64::max));
    (per, format!("time [{unit}]"))
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
    let tables = output.rows.of_measurement(measurement);
    let moments = tables.flat_map(Table::moments_read);
    let times: Vec<(f64, bool)> = moments.filter_map(|own| Some((own.time_s?, own.held_out))).collect();
    let (per, title) = time_axis(&times);
    let strips: Vec<Strip> = sensors
        .iter()
        .map(|(sensor, _)| Strip {
            label: (*sensor).to_owned(),
            points: of_sensor(output, measurement, sensor)
                .into_iter()
                .map(|r| (r.time_s.unwrap_or(f64::NAN) / per, r.deviation()))
                .collect(),
        })
        .collect();
    let unit = if sensors.iter().all(|s| s.1 == "K") { "K" } else { "SI" };
    let shades = scaled(held_out(times), per);
    let shaded = if shades.is_empty() { "" } else { "; the shaded time is held out from every fit" };
    Figure {
        id: format!("{job}-{measurement}-residuals"),
        drawing: residual_strips(&title, &format!("dev. [{unit}]"), &strips, &shades),
        caption: Text::new("Measured minus predicted over time, ").code(measurement).plain(format!("{shaded}.")),
        alternative: format!(
            "Residuals over time, one strip for each of {} of {measurement}{shaded}.",
            counted(sensors.len(), "sensor")
        ),
    }
}

/// Deviations of rows for fitting (`false`) or held out, root mean square; `None` without any.
fn rmse(rows: &[Row<&str>], shows: Shows, is_held_out: bool) -> Option<f64> {
    let own = rows.iter().filter(|row| row.held_out == is_held_out);
    let squares: Vec<f64> =
        own.map(|row| row.measured - shows.predicted(row)).filter(|own| own.is_finite()).map(|own| own * own).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Measured and predicted over time for one sensor, in all parts of the record to which the measurement belongs.
pub(in crate::report::section) fn time_history(
    report: &PassReport<'_>,
    job: &str,
    output: &Output,
    measurement: &str,
    sensor: &str,
    shows: Shows,
    is_small: bool,
) -> Figure {
    let parts = parts(report, output, measurement);
    let measurement = parts.first().copied().unwrap_or(measurement);
    let by_part: Vec<Vec<Row<&str>>> = parts.iter().map(|part| of_sensor(output, part, sensor)).collect();
    let rows = by_part.concat();
    let unit = rows.first().map_or("", |r| r.unit);
    let shown = report.sensor_shown(measurement, sensor, unit);
    let times: Vec<(f64, bool)> = rows.iter().filter_map(|row| Some((row.time_s?, row.held_out))).collect();
    let (per, title) = time_axis(&times);
    let shades = scaled(held_out(times), per);
    let shaded = if shades.is_empty() { "" } else { " The shaded time is held out from every fit." };
    let point = |row: &Row<&str>| {
        (row.time_s.unwrap_or(f64::NAN) / per, shown.value(row.measured), shown.value(shows.predicted(row)))
    };
    let mut points: Vec<(f64, f64, f64)> = Vec::new();
    for part in &by_part {
        // What is no number breaks the line.
        points.extend((!points.is_empty()).then_some((f64::NAN, f64::NAN, f64::NAN)));
        points.extend(part.iter().map(point));
    }
    let data = History {
        x_title: title,
        y_title: shown.title(sensor),
        residual_title: shown.difference().title(if is_small { "dev." } else { "meas. \u{2212} pred." }),
        points,
        held_out: shades,
        limit: output.criteria.each_k.filter(|_| unit == "K"),
        is_small,
    };
    let text = |value: f64| shown.difference().text(value);
    let rmse = match (rmse(&rows, shows, false), rmse(&rows, shows, true)) {
        (Some(train), Some(held_out)) => format!(" RMSE {}, held out {}.", text(train), text(held_out)),
        (Some(train), None) => format!(" RMSE {}.", text(train)),
        (None, Some(held_out)) => format!(" RMSE held out {}.", text(held_out)),
        (None, None) => String::new(),
    };
    // Of several measurements or parts the figure names its own.
    let named =
        Text::new(format!("Measured and predicted{} over time, sensor ", shows.words(report, output))).code(sensor);
    let caption = match parts.len() {
        0 | 1 if !super::has_several(output) => named,
        0 | 1 => named.plain(" of ").code(measurement),
        count => named.plain(" of ").code(measurement).plain(format!(", all {count} parts between its gaps")),
    };
    Figure {
        id: format!("{}{job}-{measurement}-{sensor}-history{}", prefix(is_small), shows.id()),
        drawing: history(&data),
        caption: caption.plain(format!(
            ".{rmse}{shaded}{}",
            if data.limit.is_some() { " Dashed: the criterion for one reading." } else { "" }
        )),
        alternative: format!("Measured and predicted {sensor} over time, with the residual below.{rmse}{shaded}"),
    }
}

fn residual_histogram(job: &str, output: &Output, measurement: &str) -> Option<Figure> {
    let rows = output.rows.of_measurement(measurement).flat_map(Table::iter).filter(|row| row.unit == "K");
    let residuals: Vec<f64> = rows.map(|row| row.deviation()).filter(|d| d.is_finite()).collect();
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
    let mut limits = vec![Limit { along: Along::X, value: 0.0, label: String::new(), colour: palette::INK }];
    if let Some(limit) = output.criteria.each_k.filter(|l| *l <= largest) {
        limits.extend([-limit, limit].map(|value| Limit {
            along: Along::X,
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
    let caption = format!("All deviations of {measurement}, {}.", counted(residuals.len(), "reading"));
    Some(Figure {
        id: format!("{job}-{measurement}-deviations"),
        drawing: chart.draw(),
        alternative: format!("Histogram. {caption}"),
        caption: caption.into(),
    })
}
