//! Readings of a sensor against an input or another sensor, beside the model's prediction and estimates of others.

use crate::math::sort::sort_by;
use crate::measurement::{Measurement, Phase};
use crate::report::number::{Shown, as_given, with_unit};
use crate::report::page::Figure;
use crate::report::plot::{Axis, Chart, Layer, Mark, Stroke, palette};
use crate::report::view::PassReport;
use crate::study::figure::{Readings, Source};

use super::{phases, predicted, spread};

/// A phase on the two axes: as read, and as predicted where that is known.
struct Point {
    read: (f64, f64),
    predicted: Option<(f64, f64)>,
    held_out: bool,
    by: Option<f64>,
}

/// The figure, or why there is none.
pub(super) fn figure(report: &PassReport<'_>, name: &str, own: &Readings) -> Result<Figure, String> {
    let measured = report.measurements.iter().find(|measured| measured.name == own.measurement);
    let measured = measured.ok_or_else(|| format!("the readings of {} are not here", own.measurement))?;
    let (x, y) = (shown(report, measured, own.against), difference_shown(report, measured, own));
    let mut is_tuned = false;
    let mut points: Vec<Point> = Vec::new();
    for (row, phase) in phases(measured) {
        let read = |source| value(measured, row, phase, source);
        let of = Source::Sensor(own.sensor);
        let Some(read) = point(own, of, read) else { continue };
        let model = |source| match source {
            Source::Input(index) => phase.inputs.get(index).copied(),
            Source::Sensor(index) => {
                let (value, tuned) =
                    predicted(report, &measured.name, &measured.sensors.get(index)?.name, &phase.name)?;
                is_tuned |= tuned;
                Some(value)
            }
        };
        let by = own.by.and_then(|input| phase.inputs.get(input).copied());
        points.push(Point { read, predicted: point(own, of, model), held_out: phase.held_out, by });
    }
    if points.is_empty() {
        return Err(format!("no phase of {} has both readings", measured.name));
    }
    let mut series: Vec<Option<f64>> = points.iter().map(|point| point.by).collect();
    sort_by(&mut series, |a, b| a.unwrap_or(0.0).total_cmp(&b.unwrap_or(0.0)));
    series.dedup();
    let place = |(at, of): (f64, f64)| (x.value(at), y.value(of));
    let mut layers = Vec::new();
    for (position, by) in series.iter().enumerate() {
        let colour = palette::series(position);
        let in_series = || points.iter().filter(|point| point.by == *by);
        let mut line: Vec<(f64, f64)> = in_series().filter_map(|point| point.predicted).map(place).collect();
        sort_by(&mut line, |a, b| a.0.total_cmp(&b.0));
        layers.push(Layer::Line { points: line, colour, stroke: Stroke::Solid, label: String::new() });
        let label = by.zip(own.by).map_or(String::new(), |(value, input)| series_label(report, input, value));
        for (held_out, mark, label) in [(false, Mark::Disc, label), (true, Mark::Ring, String::new())] {
            let points =
                in_series().filter(|point| point.held_out == held_out).map(|point| place(point.read)).collect();
            layers.push(Layer::Dots { points, colour, mark, label });
        }
    }
    for (position, estimate) in own.estimates.iter().enumerate() {
        let colour = if position == 0 { palette::INK } else { palette::MUTED };
        let points = estimate.points.iter().map(|point| place(*point)).collect();
        let label = match estimate.reconstructed {
            Some(_) => format!("{} (reconstructed)", estimate.name),
            None => estimate.name.clone(),
        };
        layers.push(Layer::Line { points, colour, stroke: Stroke::Dashed, label });
    }
    let (of, against) = (title(report, measured, own), source_name(report, measured, own.against));
    let chart = Chart { x: Axis::new(x.title(&against)), y: Axis::new(y.title(&of)), layers, ..Chart::default() };
    let deviations: Vec<f64> = points.iter().filter_map(|point| Some(point.read.1 - point.predicted?.1)).collect();
    let state = if is_tuned { "the tuned model".to_owned() } else { format!("the model {}", report.untuned()) };
    let error = spread(&deviations).map_or(String::new(), |[rms, largest]| {
        let shown = y.difference();
        format!(
            " Lines: {state}; measured minus predicted {} root mean square, {} at most.",
            shown.text(rms),
            shown.text(largest)
        )
    });
    let held_out = if points.iter().any(|point| point.held_out) { ", rings held out" } else { "" };
    let dashed = if own.estimates.is_empty() { "" } else { " Dashed: estimates of others." };
    let caption = format!("{of} against {against}, {}: points as read{held_out}.{error}{dashed}", own.measurement);
    Ok(Figure {
        id: format!("figure-{name}"),
        drawing: chart.draw(),
        alternative: format!("Chart. {caption}"),
        caption: caption.into(),
    })
}

/// Both coordinates by what gives a source's value.
fn point(own: &Readings, of: Source, mut value: impl FnMut(Source) -> Option<f64>) -> Option<(f64, f64)> {
    let taken_off = own.minus.map_or(Some(0.0), &mut value)?;
    let (at, of) = (value(own.against)?, value(of)?);
    (at.is_finite() && of.is_finite()).then_some((at, of - taken_off))
}

/// A source's value in a phase, SI.
fn value(measured: &Measurement, row: usize, phase: &Phase, source: Source) -> Option<f64> {
    match source {
        Source::Input(index) => phase.inputs.get(index).copied(),
        Source::Sensor(index) => measured.readings.get(row * measured.sensors.len() + index).copied().flatten(),
    }
}

fn source_name(report: &PassReport<'_>, measured: &Measurement, source: Source) -> String {
    match source {
        Source::Input(index) => report.model.inputs.get(index).map(|own| own.name.clone()),
        Source::Sensor(index) => measured.sensors.get(index).map(|own| own.name.clone()),
    }
    .unwrap_or_default()
}

/// `sdd_hsg` or `sdd_hsg minus T_orex`.
fn title(report: &PassReport<'_>, measured: &Measurement, own: &Readings) -> String {
    let of = source_name(report, measured, Source::Sensor(own.sensor));
    match own.minus {
        Some(minus) => format!("{of} minus {}", source_name(report, measured, minus)),
        None => of,
    }
}

fn shown(report: &PassReport<'_>, measured: &Measurement, source: Source) -> Shown {
    match source {
        Source::Input(index) => Shown::written(report.model.inputs.get(index).map_or("1", |own| own.unit.as_str())),
        Source::Sensor(index) => {
            let quantity = measured.sensors.get(index).and_then(|own| report.model.quantities.get(own.quantity));
            quantity.map_or_else(|| Shown::si(""), |own| Shown::quantity(&own.unit, own.is_temperature))
        }
    }
}

fn difference_shown(report: &PassReport<'_>, measured: &Measurement, own: &Readings) -> Shown {
    let of = shown(report, measured, Source::Sensor(own.sensor));
    if own.minus.is_some() { of.difference() } else { of }
}

/// `T_orex 30 °C`.
fn series_label(report: &PassReport<'_>, input: usize, value: f64) -> String {
    let Some(own) = report.model.inputs.get(input) else { return String::new() };
    let shown = Shown::written(&own.unit);
    format!("{} {}", own.name, with_unit(&as_given(shown.value(value)), &shown.unit))
}
