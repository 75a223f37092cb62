//! Calibrations and diagnoses on sensors whose noise is not stated: they do not run, everything else does.

use crate::document::{Diagnostic, code};
use crate::inference::likelihood::rows::used_rows;
use crate::measurement::Measurement;
use crate::study::job::NamedJob;
use crate::study::pass::PassForm;
use crate::study::resolved::Refused;

use super::scope::Scope;

/// The calibrations and diagnoses that a sensor without `sigma` keeps from running.
pub(super) fn refused(scope: &Scope, jobs: &[NamedJob], form: &PassForm, measurements: &[Measurement]) -> Vec<Refused> {
    let mut refused = Vec::new();
    for job in jobs {
        let Some(inference) = job.spec.inference() else { continue };
        // A measurement with an error of its own is not among them.
        for measurement in inference.data.iter().filter_map(|&index| measurements.get(index)) {
            let rows = used_rows(measurement);
            for sensor in measurement.sensors.iter().filter(|sensor| sensor.sigma.is_none()) {
                // Nothing is asked of a sensor without a reading to fit.
                let used = rows.iter().any(|row| row.readings.iter().any(|(name, _)| *name == sensor.name));
                let entry = form.measurements.get(&measurement.name).map(|entry| entry.value.sensors());
                let Some(entry) = entry.and_then(|sensors| sensors.get(&sensor.name)).filter(|_| used) else {
                    continue;
                };
                let unit = &scope.resolved.model.quantities[sensor.quantity].unit;
                let message = format!(
                    "sensor `{}` of `{}` has no `sigma`: `{}` needs its noise and does not run",
                    sensor.name, measurement.name, job.name
                );
                let help = format!(
                    "write \"sigma\": {{\"value\": ..., \"unit\": \"{unit}\"}}, or \"sigma\": {{\"prior\": {{\"lognormal\": \
                     {{\"median\": ..., \"factor\": ...}}}}, \"unit\": \"{unit}\"}} to infer it"
                );
                let diagnostic = Diagnostic::error(&code::NO_SIGMA, &entry.name_place, message)
                    .expected("a sensor with `sigma`")
                    .help(help);
                refused.push(Refused { job: job.name.clone(), diagnostic });
            }
        }
    }
    refused
}
