//! Phases that drift, stated of the measurements so that what rests on them can repeat it.

use crate::document::{Diagnostic, code, counted};
use crate::measurement::{Doubt, Measurement, Rows};
use crate::study::job::NamedJob;
use crate::study::pass::PassForm;

use super::plausible::short;
use super::scope::Scope;

/// Phases named in a message.
const NAMED: usize = 6;
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;

/// Tells which phases that are fitted or compared drift, by the strictest stabilisation of the comparisons with them.
pub(super) fn doubts(scope: &mut Scope, form: &PassForm, jobs: &[NamedJob], measurements: &mut [Measurement]) {
    for (index, measurement) in measurements.iter_mut().enumerate() {
        let comparisons = jobs.iter().filter_map(|job| job.spec.comparison());
        let limits = comparisons
            .filter(|comparison| comparison.data.contains(&index))
            .filter_map(|comparison| comparison.stabilisation_k_per_s);
        let Some(limit) = limits.reduce(f64::min) else { continue };
        let sensors = measurement.sensors_in_kelvin(&scope.resolved.model);
        let Rows::Steady(phases) = &measurement.rows else { continue };
        let mut drifting: Vec<String> = Vec::new();
        for phase in phases.iter().filter(|phase| phase.ignored.is_none()) {
            let Some(steadiness) = &phase.stabilisation else { continue };
            let Some(sensor) = steadiness.drifting(&sensors, limit) else { continue };
            let slope = short(steadiness.slopes[sensor].unwrap_or_default() * HOUR_S);
            drifting.push(format!("`{}` (`{}` by {slope} K/h)", phase.name, measurement.sensors[sensor].name));
        }
        let Some(entry) = form.measurements.get(&measurement.name).filter(|_| !drifting.is_empty()) else { continue };
        let (count, all) = (drifting.len(), phases.len());
        if count > NAMED {
            drifting.truncate(NAMED);
            drifting.push(format!("{} more", count - NAMED));
        }
        let drift = if count == 1 { "drifts" } else { "drift" };
        let message = format!(
            "{count} of {} of `{}` {drift} faster than {} K/h: {}",
            counted(all, "phase"),
            measurement.name,
            short(limit * HOUR_S),
            drifting.join(", ")
        );
        let help = "choose a later window, ignore the phase with a reason, or compare the log as a transient";
        let doubt = Diagnostic::warning(&code::NOT_STABILISED, &entry.name_place, message).help(help);
        measurement.doubts.push(Doubt::from(&doubt));
        scope.doubts.push(doubt);
    }
}
