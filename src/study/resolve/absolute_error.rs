//! Logged sensors without an absolute error: said once a pass.

use crate::document::suggest::listed;
use crate::document::{Diagnostic, code};
use crate::measurement::{Measurement, Rows, Sensor, Uncertain};
use crate::study::pass::PassForm;

use super::scope::Scope;

/// A noise below this is the rounding of a computed record, K: such a record has no thermometers.
const LEAST_NOISE_K: f64 = 0.005;
/// Sensors that a message names.
const NAMED: usize = 6;

/// Says which thermometers of transients have a white noise and no other error: with many rows, that leaves hardly any.
pub(super) fn warn(scope: &mut Scope, form: &PassForm, measurements: &[Measurement]) {
    let is_bare = |sensor: &&Sensor| {
        let sigma = sensor.sigma.as_ref().map(Uncertain::nominal);
        let is_noisy = sigma.is_some_and(|sigma| sigma >= LEAST_NOISE_K);
        is_noisy && sensor.bias.is_none() && sensor.correlation_time_s.is_none()
    };
    let found = measurements.iter().find_map(|measurement| {
        let Rows::Transient { .. } = measurement.rows else { return None };
        let thermometers = measurement.sensors_in_kelvin(&scope.resolved.model);
        let own = thermometers.into_iter().map(|position| &measurement.sensors[position]);
        let names: Vec<&str> = own.filter(is_bare).map(|own| own.name.as_str()).collect();
        let entry = form.measurements.get(&measurement.name)?;
        (!names.is_empty()).then_some((names, entry))
    });
    let Some((names, entry)) = found else { return };
    let message = format!(
        "no absolute error is stated of {} of `{}`: `sigma` is noise from row to row, which many rows average out, so that an offset \
         of a sensor is laid to the model and what is fitted looks more certain than it is",
        listed(names.iter().copied(), NAMED),
        entry.name
    );
    let help = "state a \"bias\" beside \"sigma\", by the calibration certificate or the type, such as {\"prior\": {\"normal\": \
                {\"mean\": 0, \"sd\": 0.75}}, \"unit\": \"K\"} for 1.5 K of a thermocouple of IEC 60584 class 1; {\"value\": 0, \
                \"unit\": \"K\"} says that there is none";
    scope.diagnostics.push(Diagnostic::warning(&code::NO_ABSOLUTE_ERROR, &entry.name_place, message).help(help));
}
