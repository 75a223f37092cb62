//! The largest measured minus predicted at each node of a network.

use crate::expression::Symbol;
use crate::job::compare::Kind;
use crate::report::section::validation::tuned_in;
use crate::report::view::PassReport;

use super::{Shows, full_scale};

/// What the sensors say at the nodes.
pub(in crate::report::section) struct AtNodes {
    /// The largest deviation at each node of the model, K; `None` where no temperature is measured.
    pub(in crate::report::section) largest: Vec<Option<f64>>,
    /// Magnitude of the full colour, as in the maps.
    pub(in crate::report::section) full_scale: f64,
    /// Of which state of the model they are.
    pub(in crate::report::section) state: &'static str,
}

/// The node that a sensor measures, where its quantity depends on the temperature of one alone.
fn node(report: &PassReport<'_>, measurement: &str, sensor: &str) -> Option<usize> {
    let measurement = report.measurements.iter().find(|own| own.name == measurement)?;
    let sensor = measurement.sensors.iter().find(|own| own.name == sensor)?;
    let value = report.model.quantities.get(sensor.quantity)?.value;
    match report.model.graph.symbols(value.expression()).into_iter().collect::<Vec<_>>().as_slice() {
        [Symbol::Node(node)] => Some(*node as usize),
        _ => None,
    }
}

/// The deviations of the first comparison that has any; none where all agree with the model to the last digit, or where the
/// predictions of the pass rest on another state.
pub(in crate::report::section) fn at_nodes(report: &PassReport<'_>) -> Option<AtNodes> {
    let output = report.outputs::<Kind>().map(|(_, output)| output).find(|output| !output.rows.is_empty())?;
    if tuned_in(report).is_some() {
        return None;
    }
    let shows = Shows::of(output);
    let mut largest: Vec<Option<f64>> = vec![None; report.model.nodes.len()];
    for sensor in output.sensors.iter().filter(|sensor| sensor.unit == "K") {
        let place = node(report, &sensor.measurement, &sensor.sensor).and_then(|node| largest.get_mut(node));
        let Some(own) = place else { continue };
        let rows = output.rows.of(&sensor.measurement, &sensor.sensor);
        for deviation in rows.map(|row| row.measured - shows.predicted(&row)).filter(|deviation| deviation.is_finite())
        {
            if own.is_none_or(|own: f64| deviation.abs() > own.abs()) {
                *own = Some(deviation);
            }
        }
    }
    let full_scale = full_scale(report);
    (full_scale > 0.0).then(|| AtNodes { largest, full_scale, state: shows.words(report, output) })
}
