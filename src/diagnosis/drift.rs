//! Steady phases that were still drifting: the heat that they stored is missing to every steady model.

use super::Problem;
use crate::inference::measurement::{Rows, Stabilisation};

/// Standard errors of the slope beyond which a sensor drifts.
const CLEARLY: f64 = 3.0;

/// A warning for each measurement with phases, fitted or held out, that drift in their windows.
pub(super) fn warnings(problem: &Problem) -> Vec<String> {
    let mut warnings = Vec::new();
    for measurement in &problem.measurements {
        let Rows::Steady(phases) = &measurement.rows else { continue };
        let mut drifting = Vec::new();
        for phase in phases.iter().filter(|phase| phase.ignored.is_none()) {
            let Some(own) = &phase.stabilisation else { continue };
            let in_kelvin =
                |sensor: &usize| problem.model.quantities[measurement.sensors[*sensor].quantity].unit == "K";
            let slopes = (0..measurement.sensors.len()).filter(in_kelvin).filter_map(|sensor| {
                let sigma = measurement.sensors[sensor].sigma.as_ref().map_or(0.0, |sigma| sigma.nominal());
                Some((sensor, drift(own, sensor, sigma)?))
            });
            let fastest = slopes.reduce(|best, next| if next.1.abs() > best.1.abs() { next } else { best });
            if let Some((sensor, slope)) = fastest {
                let (sensor, hourly) = (&measurement.sensors[sensor].name, 3600.0 * slope);
                drifting.push(format!("phase {} ({sensor} {hourly:+.2} K/h)", phase.name));
            }
        }
        if !drifting.is_empty() {
            warnings.push(format!(
                "{} was not steady in {}: the heat that was stored there looks like something missing. Leave such a phase out, or \
                 give it as a transient",
                measurement.name,
                drifting.join(", ")
            ));
        }
    }
    warnings
}

/// The slope of a sensor in a window, K/s, where it is clear and changes the reading by more than its noise.
fn drift(window: &Stabilisation, sensor: usize, sigma: f64) -> Option<f64> {
    let slope = *window.slopes.get(sensor)?.as_ref()?;
    let error = window.slope_errors.get(sensor).copied().flatten()?;
    let change = slope.abs() * (window.to_s - window.from_s);
    (slope.abs() > CLEARLY * error && change > sigma).then_some(slope)
}
