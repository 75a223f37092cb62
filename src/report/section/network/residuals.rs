//! The colour of a network's nodes: the largest measured minus predicted of the sensors at each.

use crate::expression::Symbol;
use crate::job::compare::{Kind, Output};
use crate::report::plot::Diagram;
use crate::report::section::comparison::{Shows, full_scale};
use crate::report::view::PassReport;

/// The comparison that is shown.
fn compared<'r>(report: &'r PassReport<'_>) -> Option<&'r Output> {
    report.outputs::<Kind>().map(|(_, output)| output).find(|output| !output.rows.is_empty())
}

/// Of which state of the model the deviations are.
pub(super) fn words(report: &PassReport<'_>) -> &'static str {
    compared(report).map_or("", |output| Shows::of(output).words(output))
}

/// The node that a sensor measures, where its quantity is the temperature of one.
fn node(report: &PassReport<'_>, measurement: &str, sensor: &str) -> Option<usize> {
    let measurement = report.measurements.iter().find(|own| own.name == measurement)?;
    let sensor = measurement.sensors.iter().find(|own| own.name == sensor)?;
    let symbols = report.model.graph.symbols(report.model.quantities.get(sensor.quantity)?.value.expression());
    match symbols.into_iter().collect::<Vec<_>>().as_slice() {
        [Symbol::Node(node)] => Some(*node as usize),
        _ => None,
    }
}

/// Gives nodes their deviations, on the scale of the maps; `place` says which box stands for a node.
pub(super) fn colour(report: &PassReport<'_>, diagram: &mut Diagram, place: impl Fn(usize) -> usize) {
    let Some(output) = compared(report) else { return };
    let shows = Shows::of(output);
    let mut largest: Vec<Option<f64>> = vec![None; diagram.nodes.len()];
    for sensor in output.sensors.iter().filter(|sensor| sensor.unit == "K") {
        let Some(node) = node(report, &sensor.measurement, &sensor.sensor).map(&place) else { continue };
        let Some(own) = largest.get_mut(node) else { continue };
        let rows =
            output.rows.iter().filter(|row| row.sensor == sensor.sensor && row.measurement == sensor.measurement);
        for deviation in rows.map(|row| row.measured - shows.predicted(row)).filter(|deviation| deviation.is_finite()) {
            if own.is_none_or(|own: f64| deviation.abs() > own.abs()) {
                *own = Some(deviation);
            }
        }
    }
    let full_scale = full_scale(report);
    if full_scale > 0.0 {
        diagram.full_scale = full_scale;
        diagram.deviations = largest;
    }
}
