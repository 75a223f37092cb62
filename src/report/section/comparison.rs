//! Model against measurements: criteria, sensors, phases, residuals in time, trends, heat balance, steadiness.

mod at_nodes;
mod brief;
mod figures;

use std::collections::BTreeSet;

use crate::document::counted;
use crate::document::suggest::listed;
use crate::job::compare::{Deviation, HeatBalance, KELVIN, Kind, Output, SensorSummary, Trend};
use crate::math::sort::sort_by;
use crate::measurement::Rows;
use crate::report::number::{
    NONE, Shown, as_given, fixed, percent, signed, significant, stated, typeset, with_error, with_unit,
};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;

pub(super) use at_nodes::{AtNodes, at_nodes};
use figures::full_scale;
pub(super) use figures::{Shows, phase_map, time_history};

/// Readings up to which the table of all of them is part of the report.
const MOST_ROWS: usize = 300;

/// Heat below this, W, is 0.
const LEAST_HEAT_W: f64 = 5e-7;
/// Share of a phase's largest heat below which what is stored or not balanced is rounding of the solver.
const LEAST_SHARE: f64 = 1e-5;

/// Names that a sentence lists.
const NAMED: usize = 6;

/// Sensors up to which all stand in the table; of more the worst ones do.
const MOST_SENSORS: usize = 24;
/// So many of the worst.
const WORST_SENSORS: usize = 20;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Comparison);

/// The section on the comparison; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.outputs::<Kind>().count();
    for (name, output) in report.outputs::<Kind>() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        blocks.push(Block::Paragraph(
            Text::new("Parameters: ")
                .strong(format!("nominal, the model {}", report.untuned()))
                .plain(". Deviations are measured minus predicted: positive where the model is too low."),
        ));
        blocks.extend(where_it_fails(output));
        let doubts = output.warnings.iter().map(|doubt| Block::callout(Tone::Warning, Text::with_names(doubt)));
        blocks.extend(doubts);
        blocks.extend(sensors(output));
        blocks.extend(figures::figures(report, name, output));
        blocks.extend(phases(output));
        blocks.extend(criteria(output));
        blocks.extend(trends(output));
        blocks.extend(heat(output));
        blocks.extend(stabilisation(output));
        if output.rows.len() > MOST_ROWS {
            let text = Text::new(format!("All {} readings beside their predictions are in ", output.rows.len()));
            let text =
                if output.rows.arrays().is_empty() { text } else { text.code("results/*.npy").plain(" beside ") };
            blocks.push(Block::Paragraph(text.code("results.json").plain(".")));
        } else {
            blocks.extend(readings(report, output, has_several(output)));
        }
    }
    (!blocks.is_empty()).then(|| Section { id: "comparison", title: "Model against measurements".into(), blocks })
}

/// The readings alone, all of them; not without such a job.
pub fn readings_alone(report: &PassReport<'_>) -> Option<Section> {
    let blocks: Vec<Block> =
        report.outputs::<Kind>().filter_map(|(_, output)| readings(report, output, true)).collect();
    (!blocks.is_empty()).then(|| Section { id: "readings", title: "Readings".into(), blocks })
}

/// Whether there are several measurements.
fn has_several(output: &Output) -> bool {
    output.sensors.windows(2).any(|pair| pair[0].measurement != pair[1].measurement)
}

/// A table whose first column names the measurement, which says nothing where there is only one.
fn by_measurement(mut table: Table, has_several: bool) -> Block {
    if has_several {
        table.columns.insert(0, Column::text("Measurement"));
    } else {
        table.rows.iter_mut().for_each(|row| drop(row.remove(0)));
    }
    Block::Table(table)
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
        blocks.push(by_measurement(
            Table {
                caption: "Phases without a prediction.".into(),
                columns: vec![Column::text("Phase"), Column::text("Reason")],
                rows,
            },
            has_several(output),
        ));
    }
    if output.fails.is_empty() {
        blocks.push(Block::callout(Tone::Verdict, nowhere(output)));
    } else {
        blocks.push(Block::paragraph("Where the model fails, worst first:"));
        blocks.push(Block::List(output.fails.iter().map(|finding| Text::with_names(finding)).collect()));
    }
    blocks
}

/// The largest RMSE, where the noise of no sensor is stated: what is not judged does not fail, however large it is. `None` where it is
/// judged, or a criterion is not kept.
fn largest_error(output: &Output) -> Option<String> {
    let is_judged = output.sensors.iter().any(|sensor| sensor.noise_rmse.is_some());
    if is_judged || output.verdicts.iter().any(|verdict| !verdict.kept) {
        return None;
    }
    let size = |sensor: &SensorSummary| (sensor.unit == KELVIN, worst_rmse(sensor));
    let order = |a: (bool, f64), b: (bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    let worst = output.sensors.iter().max_by(|a, b| order(size(a), size(b)))?;
    let rmse = with_unit(&significant(worst_rmse(worst), 2), &worst.unit);
    Some(format!("the largest RMSE is {rmse} (`{}`)", worst.sensor))
}

/// Says that the model fails nowhere, and of which sensors that says little, as their noise is not stated as a value.
fn nowhere(output: &Output) -> String {
    let is_unjudged = |sensor: &&SensorSummary| sensor.noise_rmse.is_none();
    let (in_kelvin, others): (Vec<&SensorSummary>, Vec<&SensorSummary>) =
        output.sensors.iter().filter(is_unjudged).partition(|sensor| sensor.unit == KELVIN);
    let (within, unasked) = match output.criteria.each_k {
        Some(limit) if !in_kelvin.is_empty() => (Some((limit, in_kelvin)), others),
        _ => (None, in_kelvin.into_iter().chain(others).collect()),
    };
    let names = |sensors: &[&SensorSummary]| {
        let names: BTreeSet<&str> = sensors.iter().map(|sensor| sensor.sensor.as_str()).collect();
        listed(names, NAMED)
    };
    let mut sentences = vec![match largest_error(output) {
        Some(error) => format!("No deviation exceeds a limit that is stated; {error}."),
        None => "The comparison finds no place where the model fails.".to_owned(),
    }];
    if let Some((limit, sensors)) = within {
        sentences.push(format!(
            "Of {} that means no reading more than {} K from its prediction: their noise is not stated as a value, so that smaller errors are \
             not judged here. `bmv diagnose` weighs them.",
            names(&sensors),
            limit
        ));
    }
    if !unasked.is_empty() {
        sentences.push(format!("Nothing is asked of {}: neither noise nor a limit is stated.", names(&unasked)));
    }
    sentences.join(" ")
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
        caption: Text::new("Criteria: ")
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
fn against_noise(sensor: &SensorSummary, deviation: &Deviation) -> Option<Status> {
    let [low, high] = sensor.noise_rmse_of(deviation)?;
    (deviation.count > 0).then_some(if deviation.rmse > high {
        Status::Fail
    } else if deviation.rmse < low {
        Status::Caution
    } else {
        Status::Ok
    })
}

/// The larger RMSE of the rows for fits and those held out, SI.
fn worst_rmse(sensor: &SensorSummary) -> f64 {
    sensor.train.rmse.max(sensor.held_out.rmse)
}

/// Sensor with the largest RMSE, in either kind of readings, of the tuned state where there is one, among those of the first
/// sensor's unit.
pub(super) fn worst_sensor(output: &Output) -> Option<&SensorSummary> {
    let unit = &output.sensors.first()?.unit;
    let size = |sensor: &SensorSummary| {
        let [train, held_out] =
            sensor.tuned.as_ref().map_or([&sensor.train, &sensor.held_out], |tuned| [&tuned.train, &tuned.held_out]);
        [train, held_out].into_iter().filter(|d| d.count > 0 && d.rmse.is_finite()).map(|d| d.rmse).fold(0.0, f64::max)
    };
    output.sensors.iter().filter(|sensor| &sensor.unit == unit).max_by(|a, b| size(a).total_cmp(&size(b)))
}

/// Orders sensors by RMSE; equal ones keep the file's order.
fn worst_first(sensors: &mut [&SensorSummary]) {
    sort_by(sensors, |a, b| worst_rmse(b).total_cmp(&worst_rmse(a)));
}

fn sensors(output: &Output) -> Vec<Block> {
    let has_held_out = output.sensors.iter().any(|s| s.held_out.count > 0);
    let mut rows = Vec::new();
    let mut shown: Vec<&SensorSummary> = output.sensors.iter().collect();
    let mut left_out = None;
    if shown.len() > MOST_SENSORS {
        worst_first(&mut shown);
        let others = shown.split_off(WORST_SENSORS);
        left_out = others.first().map(|next| {
            let rmse = with_unit(&significant(worst_rmse(next), 2), &next.unit);
            let count = counted(others.len(), "more sensor");
            Block::Paragraph(
                Text::new(format!("{count} with an RMSE of at most {rmse} are in ")).code("results.json").plain("."),
            )
        });
    }
    for sensor in shown {
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
                    .noise_rmse_of(deviation)
                    .map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", fixed(a, digits), fixed(b, digits)))
                    .into(),
                fixed(deviation.max, digits).into(),
                if sensor.unit == KELVIN && output.criteria.each_k.is_some() {
                    percent(deviation.within_limit, 0).into()
                } else {
                    NONE.into()
                },
                crate::report::number::typeset(&sensor.unit).into(),
            ]);
            rows.push(row);
        }
    }
    let mut columns = vec![Column::text("Sensor")];
    if has_held_out {
        columns.push(Column::text("Readings"));
    }
    let within = output.criteria.each_k.map_or_else(
        || "Within limit".to_owned(),
        |limit| format!("Within {} K", crate::report::number::as_given(limit)),
    );
    columns.extend(
        ["Number", "Mean", "Standard deviation", "RMSE", "RMSE of noise alone", "Largest", within.as_str()]
            .map(|t| Column::number(t, "")),
    );
    columns.push(Column::text("Unit"));
    let table = by_measurement(Table {
        caption: if output.sensors.iter().all(|s| s.noise_rmse.is_none()) {
            "Deviations by sensor."
        } else {
            "Deviations by sensor. An RMSE above the 95 % range that the sensor's noise alone would give is marked as a failure, one below it as worth a look."
        }
        .into(),
        columns,
        rows,
    }, has_several(output));
    std::iter::once(table).chain(left_out).collect()
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
    let table = by_measurement(
        Table {
            caption: "Deviations by phase or stretch of time, over all sensors, K.".into(),
            columns: vec![
                Column::text("Phase"),
                Column::text("Readings"),
                Column::number("Mean", ""),
                Column::number("Standard deviation", ""),
                Column::number("RMSE", ""),
                Column::text("Worst sensor"),
                Column::number("At worst", ""),
            ],
            rows,
        },
        has_several(output),
    );
    Some(if output.phases.len() > 12 {
        Block::Details(format!("Table of the phases ({})", output.phases.len()), vec![table])
    } else {
        table
    })
}

/// What a trend in time is against.
const TIME: &str = "time";
/// Trends shown at most.
const SHOWN_TRENDS: usize = 12;

fn trends(output: &Output) -> Option<Block> {
    if output.trends.is_empty() {
        return None;
    }
    let shown = || output.trends.iter().take(SHOWN_TRENDS);
    let unit_of = |t: &Trend| {
        let mut sensors = output.sensors.iter();
        sensors
            .find(|own| own.measurement == t.measurement && own.sensor == t.sensor)
            .map_or_else(|| KELVIN.to_owned(), |own| typeset(&own.unit))
    };
    let is_all_kelvin = shown().all(|t| unit_of(t) == KELVIN);
    // One unit of time for all rows of a unit, as slow changes are stated.
    let in_time = |own: &str| {
        let slopes =
            shown().filter(|t| t.against == TIME && unit_of(t) == own).map(|t| t.slope.abs().max(t.slope_error));
        let (times, unit) = stated("K/s", slopes.fold(0.0, f64::max));
        (times, unit.trim_start_matches(KELVIN).to_owned())
    };
    let rows = shown()
        .map(|t| {
            let own = unit_of(t);
            let (times, unit) = match t.unit.as_str() {
                _ if t.against == TIME => {
                    let (times, per_time) = in_time(&own);
                    (times, format!("{}{per_time}", if own.is_empty() { "1" } else { &own }))
                }
                "1" | "" => (1.0, own.clone()),
                other => {
                    let own = if own.is_empty() { "1" } else { &own };
                    // A quotient in a denominator would be read twice.
                    let over = if other.contains(['/', ' ']) { " per " } else { "/" };
                    (1.0, format!("{own}{over}{}", typeset(other)))
                }
            };
            let change = signed(t.change, decimals(&own));
            let is_clear = t.slope_error > 0.0 && t.slope.abs() > 3.0 * t.slope_error;
            vec![
                Cell::code(&t.measurement),
                Cell::code(&t.sensor),
                Cell::code(&t.against),
                if is_all_kelvin { change.into() } else { with_unit(&change, &own).into() },
                with_error(times * t.slope, times * t.slope_error).into(),
                unit.into(),
                Cell { text: fixed(t.correlation, 2).into(), status: is_clear.then_some(Status::Caution) },
            ]
        })
        .collect();
    Some(by_measurement(Table {
        caption: "What the deviations go with, strongest first; marked where the slope is more than three standard errors from zero. \
                  A deviation that follows an input points at the physics of that input."
            .into(),
        columns: vec![
            Column::text("Sensor"),
            Column::text("Against"),
            Column::number("Change over its range", if is_all_kelvin { KELVIN } else { "" }),
            Column::number("Slope", ""),
            Column::text("Unit of the slope"),
            Column::number("Correlation", ""),
        ],
        rows,
    }, has_several(output)))
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
    let mut columns = vec![Column::text("Phase"), Column::number("Sources", "W")];
    columns.extend(boundaries.iter().map(|b| Column::number(format!("into {b}"), "W")));
    columns.extend([Column::number("Stored", "W"), Column::number("Imbalance", "W")]);
    let from = |w: f64, least: f64| Cell::from(if w.abs() < least { "0".to_owned() } else { significant(w, 3) });
    let watts = |w: f64| from(w, LEAST_HEAT_W);
    let largest = |h: &HeatBalance| h.into_boundaries_w.iter().map(|(_, w)| w.abs()).fold(h.sources_w.abs(), f64::max);
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
            let least = LEAST_HEAT_W.max(LEAST_SHARE * largest(h));
            row.extend([from(h.stored_w, least), from(h.imbalance_w, least)]);
            row
        })
        .collect();
    let is_any_negative = output.heat.iter().flat_map(|h| &h.into_boundaries_w).any(|(_, w)| *w <= -LEAST_HEAT_W);
    let caption = match is_any_negative {
        true => "Heat balance of the model. Where heat into a boundary is negative, it flows out of it.",
        false => "Heat balance of the model.",
    };
    let table = by_measurement(Table { caption: caption.into(), columns, rows }, has_several(output));
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
            vec![
                Cell::code(&s.measurement),
                Cell::code(&s.phase),
                Cell::code(&s.sensor),
                with_error(3600.0 * s.drift_k_per_s, 3600.0 * s.drift_error_k_per_s).into(),
                significant(s.stored_w, 3).into(),
                s.stabilised.map_or_else(
                    || Cell::from(NONE),
                    |kept| match (kept, s.unclear) {
                        (true, true) => Cell::marked("too noisy to tell", Status::Caution),
                        (true, false) => Cell::marked("steady", Status::kept(true)),
                        (false, _) => Cell::marked("drifts", Status::kept(false)),
                    },
                ),
            ]
        })
        .collect();
    Some(by_measurement(
        Table {
            caption: "Steadiness of the phases: the fastest drift, and the heat that it hides.".into(),
            columns: vec![
                Column::text("Phase"),
                Column::text("Sensor"),
                Column::number("Drift", "K/h"),
                Column::number("Heat stored", "W"),
                Column::text("Outcome"),
            ],
            rows,
        },
        has_several(output),
    ))
}

/// The last instant of a record, s.
fn longest_s(report: &PassReport<'_>, measurement: &str) -> f64 {
    let own = report.measurements.iter().find(|own| own.name == measurement);
    own.map_or(0.0, |own| match &own.rows {
        Rows::Steady(_) => 0.0,
        Rows::Transient { inputs, .. } => inputs.longest_s(),
    })
}

fn readings(report: &PassReport<'_>, output: &Output, has_several: bool) -> Option<Block> {
    if output.rows.is_empty() {
        return None;
    }
    let rows = output
        .rows
        .iter()
        .map(|r| {
            let shown: Shown = report.sensor_shown(r.measurement, r.sensor, r.unit);
            let moment = match (r.phase, r.time_s) {
                (Some(phase), _) => Cell::code(phase),
                (None, Some(time_s)) => {
                    let time = Shown::time(longest_s(report, r.measurement));
                    with_unit(&as_given(time.value(time_s)), &time.unit).into()
                }
                (None, None) => NONE.into(),
            };
            vec![
                Cell::code(r.measurement),
                moment,
                Cell::code(r.sensor),
                shown.number(r.measured).into(),
                shown.number(r.predicted).into(),
                signed(r.deviation(), decimals(r.unit)).into(),
                shown.unit.clone().into(),
                (if r.held_out { "held out" } else { "" }).into(),
            ]
        })
        .collect();
    let table = by_measurement(
        Table {
            caption: "Readings beside predictions.".into(),
            columns: vec![
                Column::text("Phase or time"),
                Column::text("Sensor"),
                Column::number("Measured", ""),
                Column::number("Predicted", ""),
                Column::number("Deviation", ""),
                Column::text("Unit"),
                Column::text(""),
            ],
            rows,
        },
        has_several,
    );
    Some(Block::Details(format!("All readings ({})", output.rows.len()), vec![table]))
}
