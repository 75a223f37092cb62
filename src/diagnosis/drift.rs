//! Steady phases that were still drifting: the heat that they stored is missing to every steady model.

use super::Problem;
use crate::inference::measurement::{Rows, Stabilisation};

/// Standard errors of the slope beyond which a sensor drifts.
const CLEARLY: f64 = 3.0;

/// Warnings of phases, fitted or held out, that drift in their window.
pub(super) fn warnings(problem: &Problem) -> Vec<String> {
    let mut warnings = Vec::new();
    for measurement in &problem.measurements {
        let Rows::Steady(phases) = &measurement.rows else { continue };
        for phase in phases.iter().filter(|phase| phase.ignored.is_none()) {
            let Some(own) = &phase.stabilisation else { continue };
            let is_kelvin =
                |sensor: &usize| problem.model.quantities[measurement.sensors[*sensor].quantity].unit == "K";
            let drifting = (0..measurement.sensors.len()).filter(is_kelvin).filter_map(|sensor| {
                let sigma = measurement.sensors[sensor].sigma.as_ref().map_or(0.0, |sigma| sigma.nominal());
                Some((sensor, drift(own, sensor, sigma)?))
            });
            let fastest = drifting.reduce(|best, next| if next.1.abs() > best.1.abs() { next } else { best });
            if let Some((sensor, slope)) = fastest {
                warnings.push(format!(
                    "phase {} of {} was not steady: {} still drifted by {:+.2} K/h in its window. The heat that it stored looks like \
                     something missing; leave the phase out or give it as a transient",
                    phase.name,
                    measurement.name,
                    measurement.sensors[sensor].name,
                    3600.0 * slope
                ));
            }
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
